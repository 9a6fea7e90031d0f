"""Values of rooms that contradict each other or the Earth, and right ones that look alike."""

from __future__ import annotations

from pathlib import Path

import pytest
from golden import Golden

from nrp_core import read_model, read_scene
from nrp_core.errors import SceneError

_ROOM = """<sdf version="1.9"><world name="room">{earth}
  <light name="lamp" type="{kind}"><pose>0 0 3 0 0 0</pose>{light}</light></world></sdf>"""


def _warnings(folder: Path, *, earth: str = "", kind: str = "spot", light: str = "") -> list[str]:
    (folder / "room.sdf").write_text(_ROOM.format(earth=earth, kind=kind, light=light))
    return [one.message for one in read_scene(folder / "room.sdf").warnings]


def _factors(*factors: float) -> str:
    tags = zip(("constant", "linear", "quadratic"), factors, strict=True)
    return f"<attenuation>{''.join(f'<{tag}>{value}</{tag}>' for tag, value in tags)}</attenuation>"


_CONE = "<spot><inner_angle>{}</inner_angle><outer_angle>{}</outer_angle></spot>"


@pytest.mark.parametrize(
    ("kind", "light", "words"),
    [
        ("spot", _CONE.format(0.9, 0.3), "the <inner_angle> of a spot, 0.9 rad, is above its <outer_angle>"),
        ("spot", _CONE.format(0.3, 0.3), ""),
        ("spot", _CONE.format(0, 1.1), ""),
        (
            "point",
            _factors(0, 0, 0),
            "the <attenuation> of the light 'lamp' are 0, so it is infinitely bright",
        ),
        ("point", _factors(0, 0, 0.1), ""),
        ("directional", _factors(0, 0, 0), ""),  # it has no distance
    ],
)
def test_a_light_that_contradicts_itself_is_reported(
    tmp_path: Path, kind: str, light: str, words: str
) -> None:
    said = _warnings(tmp_path, kind=kind, light=light)
    assert [words in one for one in said] == [True] * bool(words)


def test_a_light_that_darkens_is_refused(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(SceneError, match="<intensity>.*-1"):
        _warnings(tmp_path, light="<intensity>-1</intensity>")
    assert _warnings(tmp_path, light="<intensity>0</intensity>") == []


@pytest.mark.parametrize(
    ("earth", "words"),
    [
        ("<magnetic_field>20 0 -43</magnetic_field>", "47.4236 T, and that of the Earth at most 7e-05 T"),
        ("<magnetic_field>6e-06 2.3e-05 -4.2e-05</magnetic_field>", ""),
        ("<magnetic_field>0 0 0</magnetic_field>", ""),
    ],
)
def test_a_magnetic_field_in_another_unit_is_reported(tmp_path: Path, earth: str, words: str) -> None:
    assert [words in one for one in _warnings(tmp_path, earth=earth)] == [True] * bool(words)


@pytest.mark.parametrize(("tag", "angle"), [("latitude_deg", "200"), ("longitude_deg", "-400")])
def test_a_place_that_is_not_on_the_earth_is_refused(
    tmp_path: Path, tag: str, angle: str, golden: Golden
) -> None:
    earth = f"<spherical_coordinates><{tag}>{{}}</{tag}></spherical_coordinates>"
    with golden.raises(SceneError, match=f"<{tag}>.*{angle}"):
        _warnings(tmp_path, earth=earth.format(angle))
    assert _warnings(tmp_path, earth=earth.format("-89.9")) == []


def test_a_sensor_in_a_joint_of_a_static_model_is_left_out(tmp_path: Path) -> None:
    body = "<inertial><mass>1</mass></inertial>"
    sensor = '<sensor name="load" type="force_torque"><update_rate>50</update_rate></sensor>'
    text = f"""<sdf version="1.9"><model name="post"><static>{{}}</static>
      <link name="foot">{body}</link><link name="pole">{body}</link>
      <joint name="j" type="fixed"><parent>foot</parent><child>pole</child>{sensor}</joint></model></sdf>"""
    path = tmp_path / "post.sdf"
    counts = {}
    for static in ("true", "false"):
        path.write_text(text.format(static))
        model = read_model(path)
        told = ["measures in a joint, and the model is static" in one.message for one in model.warnings]
        counts[static] = (sum(len(link.sensors) for link in model.links), sum(told))
    assert counts == {"true": (0, 1), "false": (1, 0)}
