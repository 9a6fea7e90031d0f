"""Rooms as Gazebo saves and reads them: static parts, lights, friction of grounds, and lenient XML."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.findings import Code
from nrp_core.scene.meshes.collada import parse_collada
from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_scene
from nrp_core.xml import strict_xml

SHELF = """<sdf version="1.6"><model name="shelf">{flag}<link name="l"><collision name="c"><geometry>
<box><size>1 1 1</size></box></geometry></collision></link></model></sdf>"""


def _scene(folder: Path, inside: str) -> Scene:
    (folder / "room.sdf").write_text(f'<sdf version="1.6"><world name="w">{inside}</world></sdf>')
    return read_scene(folder / "room.sdf")


def _with_shelf(folder: Path, flag: str = "", config: str = "") -> None:
    (folder / "shelf").mkdir()
    (folder / "shelf" / "model.sdf").write_text(SHELF.format(flag=flag))
    (folder / "shelf" / "model.config").write_text(
        config or "<model><sdf version='1.6'>model.sdf</sdf></model>"
    )


@pytest.mark.parametrize(
    ("flag", "inside", "static"),
    [
        ("<static>1</static>", "<include><uri>model://shelf</uri></include>", True),
        ("", "<include><uri>model://shelf</uri><static>1</static></include>", True),
        ("", "<include><uri>model://shelf</uri></include>", False),
        (
            "<static>1</static>",
            '<model name="inner"><include><uri>model://shelf</uri></include></model>',
            True,
        ),
    ],
)
def test_a_model_of_nothing_but_static_models_is_static(tmp_path, flag, inside, static):
    _with_shelf(tmp_path, flag)
    scene = _scene(tmp_path, f'<model name="m">{inside}</model>')
    assert scene.models[0].static is static
    assert all((link.inertial is None) is static for link in scene.models[0].links)
    assert not [each for each in scene.warnings if "<static>" in str(each)]


def test_a_static_model_within_one_that_moves_is_a_warning(tmp_path):
    _with_shelf(tmp_path, "<static>1</static>")
    own = '<link name="own"><inertial><mass>1</mass></inertial></link>'
    inner = "<include><uri>model://shelf</uri></include>"
    scene = _scene(tmp_path, f'<model name="m">{own}{inner}</model>')
    assert not scene.models[0].static
    assert any("<static> of the nested model 'shelf'" in str(each) for each in scene.warnings)


@pytest.mark.parametrize("kind", ["directional", "point"])
def test_only_spot_lights_have_a_cone(tmp_path, kind):
    cone = "<spot><inner_angle>0</inner_angle><outer_angle>0</outer_angle><falloff>0</falloff></spot>"
    scene = _scene(tmp_path, f'<light name="sun" type="{kind}">{cone}</light>')
    assert [light.kind for light in scene.lights] == [kind]


def test_the_friction_of_gazebos_ground_causes_no_warning(tmp_path):
    surface = "<surface><friction><ode><mu>100</mu><mu2>50</mu2></ode></friction></surface>"
    ground = f"""<link name="l"><collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry>
    {surface}</collision></link>"""
    scene = _scene(tmp_path, f'<model name="ground"><static>1</static>{ground}</model>')
    assert not list(scene.warnings)
    assert scene.models[0].links[0].collisions[0].friction > 1.0


def test_a_bare_ampersand_in_a_description_is_text(tmp_path):
    about = "<description>racks & shelves</description>"
    _with_shelf(tmp_path, config=f"<model><sdf version='1.6'>model.sdf</sdf>{about}</model>")
    assert _scene(tmp_path, "<include><uri>model://shelf</uri></include>").models[0].name == "shelf"


@pytest.mark.parametrize(
    ("given", "read"),
    [
        (b"<!-- by hand -->\n<?xml version='1.0'?>\n<a>x</a>", "<a>x</a>"),
        (
            "<!-- \u00e9 --><?xml version='1.0' encoding='latin-1'?><a>\u00e9</a>".encode("latin-1"),
            "<a>\u00e9</a>",
        ),
        (
            b"<a b='c & d'>e & f &amp; &lt; &#65; &#x41;</a>",
            "<a b='c &amp; d'>e &amp; f &amp; &lt; &#65; &#x41;</a>",
        ),
        (b"<a><![CDATA[b & c]]></a>", "<a><![CDATA[b & c]]></a>"),
    ],
)
def test_texts_that_gazebo_accepts(given, read):
    assert strict_xml(given).strip() == read


COLLADA = b"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>
<library_geometries><geometry id="g"><mesh><!-- made by hand --><source id="p">
<float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><!-- faces -->
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_comments_in_a_collada_mesh_are_skipped():
    (surface,) = parse_collada(COLLADA, lambda _: None)
    assert surface.triangles.shape == (1, 3, 3)


def test_a_mesh_of_scale_0_is_left_out_and_the_room_is_read(tmp_path):
    """Gazebo saves such a scale, and shows nothing."""
    mesh = "<geometry><mesh><uri>gone.dae</uri><scale>1 0 0</scale></mesh></geometry>"
    box = "<geometry><box><size>1 1 1</size></box></geometry>"
    shapes = f'<visual name="v">{mesh}</visual><collision name="c">{mesh}</collision>'
    link = f'<link name="l">{shapes}<collision name="b">{box}</collision></link>'
    scene = _scene(tmp_path, f'<model name="dock"><static>1</static>{link}</model>')
    assert [each.name for each in scene.model("dock").links[0].collisions] == ["b"]
    assert [(each.code, each.subject) for each in scene.warnings] == [(Code.NRP260, "v"), (Code.NRP260, "c")]
