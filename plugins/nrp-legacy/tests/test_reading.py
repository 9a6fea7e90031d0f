"""Documents are read for what they say, files found where they have been kept."""

from __future__ import annotations

from pathlib import Path

import pytest
from golden import Golden
from nrp_legacy import documents
from nrp_legacy.code import compiled_file
from nrp_legacy.documents import FileNamed, pose_of, seconds_of
from nrp_legacy.files import Library
from nrp_legacy.reader import read_exc

from nrp_core.errors import ExperimentError
from nrp_core.xml import parse_xml


def element(text: str) -> object:
    return parse_xml(text.encode(), Path("some.exc"), ExperimentError)


@pytest.mark.parametrize(
    ("said", "seconds"),
    [("840", 840.0), ("840.5", 840.5), ("PT14M", 840.0), ("PT1H0M2.5S", 3602.5), ("P1D", 86400.0)],
)
def test_a_time_out_is_seconds_or_a_duration_of_xml_schema(said: str, seconds: float) -> None:
    assert seconds_of(element(f"<timeout>{said}</timeout>")) == seconds  # type: ignore[arg-type]


def test_a_time_out_that_is_not_a_time_is_refused_at_its_line(golden: Golden) -> None:
    with golden.raises(
        ExperimentError,
        match=r"some\.exc:1: <timeout>.*PT14M.*'soon'",
    ):
        seconds_of(element("<timeout>soon</timeout>"))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("attributes", "yaw"),
    [
        ('roll="0" pitch="0" yaw="1.5"', 1.5),
        ('ux="0" uy="0" uz="0.7071068" theta="0.7071068"', 1.5707963),
        ('uz="1" theta="0"', 3.1415927),
        ('ux="0" uy="0" uz="0.7071068"', 1.5707963),
        ('ux="0" uy="0" uz="1" yaw="0.5"', 0.5),
        ("", 0.0),
    ],
)
def test_every_spelling_of_a_pose_gives_its_heading(attributes: str, yaw: float) -> None:
    pose = pose_of(element(f'<robotPose x="1" y="2" {attributes}/>'))  # type: ignore[arg-type]
    assert pose[:5] == pytest.approx((1, 2, 0, 0, 0))
    assert pose[5] == pytest.approx(yaw)


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("prefix", ["", "ns1:"])
@pytest.mark.parametrize("lead", ["", "\ufeff", "\n  "])
def test_prefixes_marks_and_line_ends_do_not_matter(tmp_path: Path, prefix: str, lead: str) -> None:
    space = "http://schemas.humanbrainproject.eu/SP10/2015/BIBI"
    declared = f'xmlns:ns1="{space}"' if prefix else f'xmlns="{space}"'
    p = prefix
    said = f"<{p}timestep>5</{p}timestep>\r\n<{p}brainModel>b.h5</{p}brainModel>"
    text = f"<{p}bibi {declared}>\r\n{said}</{p}bibi>"
    bibi = documents.read_bibi(written(tmp_path, "some.bibi", lead + text))
    assert bibi.timestep is not None
    assert bibi.timestep.text == "5"
    assert bibi.brain is not None
    assert bibi.brain.name == "b.h5"


def test_populations_are_read_by_either_name_and_bodies_by_their_ids(tmp_path: Path) -> None:
    text = """<bibi><brainModel><file>b.py</file><neuronGroup population="a" from="0" to="2"/>
    <populations population="b"><element>3</element></populations></brainModel>
    <bodyModel>one.sdf</bodyModel><bodyModel robotId="two">two.sdf</bodyModel></bibi>"""
    bibi = documents.read_bibi(written(tmp_path, "some.bibi", text))
    assert list(bibi.populations) == ["a", "b"]
    assert {name: body.name for name, body in bibi.bodies.items()} == {"robot": "one.sdf", "two": "two.sdf"}


@pytest.mark.parametrize(
    "place",
    [
        "experiment/part/model.sdf",
        "models/part/model.sdf",
        "models/robots/part/model.sdf",
        "models/a/b/part/model.sdf",
    ],
)
def test_a_file_is_found_in_the_experiment_and_in_libraries_of_all_layouts(
    tmp_path: Path, place: str
) -> None:
    path = written(tmp_path, place, "")
    (tmp_path / "experiment").mkdir(exist_ok=True)
    assert Library(tmp_path / "experiment", [tmp_path / "models"]).find_code("part/model.sdf") == path


@pytest.mark.parametrize(
    "name", ["tf.py", "storage://mine/tf.py", "../Experiments/mine/tf.py", "../experiment/tf.py", "./tf.py"]
)
def test_a_file_of_the_experiment_is_found_under_every_name(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, "experiment/tf.py", "")
    assert Library(tmp_path / "experiment").find_code(name) == path


def test_a_file_in_the_experiment_has_priority_over_the_library(tmp_path: Path) -> None:
    own = written(tmp_path, "experiment/part/model.sdf", "")
    written(tmp_path, "models/part/model.sdf", "")
    assert Library(tmp_path / "experiment", [tmp_path / "models"]).find_code("part/model.sdf") == own


def test_a_model_may_be_named_beside_its_file(tmp_path: Path) -> None:
    path = written(tmp_path, "models/robots/cart/body.sdf", "")
    library = Library(tmp_path / "experiment", [tmp_path / "models"])
    document = parse_xml(
        b'<bibi><a model="cart">body.sdf</a><b model="cart">other.sdf</b></bibi>', tmp_path, ExperimentError
    )
    assert [library.find(FileNamed.of(child)) for child in document.children] == [path, None]


def test_an_experiment_without_its_second_document_is_refused_at_the_line_that_names_it(
    tmp_path: Path,
    golden: Golden,
) -> None:
    path = written(tmp_path, "some.exc", '<ExD>\n<bibiConf src="gone.bibi"/></ExD>')
    with golden.raises(ExperimentError, match=r"some\.exc:2.*'gone.bibi'"):
        read_exc(path)


def test_a_missing_folder_of_models_is_refused(tmp_path: Path, golden: Golden) -> None:
    path = written(tmp_path, "some.exc", '<ExD><bibiConf src="some.bibi"/></ExD>')
    with golden.raises(ExperimentError):
        read_exc(path, [f"models=[{tmp_path / 'nowhere'}]"])


def test_a_file_that_is_indented_as_a_whole_is_moved_to_the_left(tmp_path: Path) -> None:
    path = tmp_path / "tf.py"
    path.write_text("    # by students\n    import math\n    def f(t):\n        return math.cos(t)\n")
    names: dict[str, object] = {}
    exec(compiled_file(path), names)
    assert names["f"](0.0) == 1.0  # type: ignore[operator]
    path.write_text("def f(t):\n    return '''kept\n    as it is'''\n")
    exec(compiled_file(path), names)
    assert names["f"](0.0) == "kept\n    as it is"  # type: ignore[operator]


@pytest.mark.parametrize(
    ("reads", "light", "chosen", "renderer"),
    [
        ("sensor_msgs.msg.Image", "<include><uri>model://sun</uri></include>", [], "realistic"),
        ("sensor_msgs.msg.Image", "<light name='l' type='point'/>", ["world.backend=pybullet"], "realistic"),
        ("sensor_msgs.msg.LaserScan", "<include><uri>model://sun</uri></include>", [], None),
        ("sensor_msgs.msg.Image", "", [], None),
        (
            "sensor_msgs.msg.Image",
            "<light name='l' type='point'/>",
            ["world.options.renderer=raster"],
            "raster",
        ),
        ("sensor_msgs.msg.Image", "<light name='l' type='point'/>", ["world.backend=gazebo"], None),
    ],
)
def test_images_that_functions_read_have_the_light_of_the_room(
    tmp_path: Path, reads: str, light: str, chosen: list[str], renderer: str | None
) -> None:
    (tmp_path / "room.sdf").write_text(f'<sdf version="1.6"><world name="w">{light}</world></sdf>')
    (tmp_path / "tf.py").write_text(
        f'@nrp.MapRobotSubscriber("seen", Topic("/r/c", {reads}))\ndef f(t, seen): 0'
    )
    (tmp_path / "x.bibi").write_text('<bibi><transferFunction src="tf.py"/></bibi>')
    exc = tmp_path / "x.exc"
    exc.write_text('<ExD><environmentModel src="room.sdf"/><bibiConf src="x.bibi"/></ExD>')
    assert read_exc(exc, chosen).world.options.get("renderer") == renderer
