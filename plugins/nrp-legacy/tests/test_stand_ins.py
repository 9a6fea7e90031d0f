"""Boxes that replace missing meshes start free of the room and of each other, so no robot is thrown."""

from __future__ import annotations

from math import acos, dist, hypot
from pathlib import Path

import pytest
from nrp_legacy.reader import read_exc

from nrp_core.experiment.running.run import Run

_MESH = "<geometry><mesh><uri>model://gone/mesh.dae</uri></mesh></geometry>"
_BOX = "<geometry><box><size>{size}</size></box></geometry>"
_ROBOT = """<sdf version="1.6"><model name="robot"><link name="body"><pose>0 0 {z} 0 0 0</pose>
<inertial><mass>{mass}</mass><inertia><ixx>{moment}</ixx><iyy>{moment}</iyy><izz>{moment}</izz></inertia>
</inertial>{shapes}</link></model></sdf>"""
_FLOOR = '<collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>'


def _static(name: str, pose: str, content: str) -> str:
    return (
        f'<model name="{name}"><static>1</static><pose>{pose}</pose><link name="l">{content}</link></model>'
    )


def _collision(geometry: str, pose: str = "0 0 0 0 0 0", name: str = "c") -> str:
    return f'<collision name="{name}"><pose>{pose}</pose>{geometry}</collision>'


def _robot(edge: float, z: float, shapes: str = _collision(_MESH)) -> str:
    """Return a robot with the mass and the inertia of a cube of water, the centre of which is at a height."""
    mass = 1000 * edge**3
    return _ROBOT.format(z=z, mass=mass, moment=mass * edge**2 / 6, shapes=shapes)


_CRATE = _static("crate", "0.5 0 0.5 0 0 0.6", _collision(_BOX.format(size="0.5 0.5 1")))
_LOST_FLOOR = _static("floor", "0 0 0 0 0 0", _collision(_MESH))
_LOST = _static("rack", "2 0.1 0 0 0 0", _collision(_MESH))
_KNOWN = _collision(_BOX.format(size="0.2 0.2 0.2"))

_TOOL_ABOVE = """<sdf version="1.6"><model name="robot"><link name="body"><inertial><mass>1000</mass><inertia>
<ixx>100</ixx><ixz>1</ixz><iyy>100</iyy><iyz>1</iyz><izz>100</izz></inertia></inertial>{base}</link>
<link name="tool"><pose>0 0 2 0 0 0</pose><inertial><mass>1</mass></inertial>{tool}</link>
<joint name="hold" type="fixed"><parent>body</parent><child>tool</child></joint></model></sdf>"""
_HOLDS = _TOOL_ABOVE.format(base=_collision(_MESH, "0 0 0.3873 0 0 0"), tool=_KNOWN)

Robots = dict[str, tuple[str, tuple[float, ...]]]
"""The file of each robot, and where it starts: x and y, m, and yaw."""

CASES: dict[str, tuple[str, Robots]] = {
    "in the floor": ("", {"a": (_robot(0.2, 0.05), (0.0, 0.0))}),
    "in the floor, turned": ("", {"a": (_robot(0.2, 0.05), (1.0, 2.0, 0.4))}),
    "in a floor without a mesh": (_LOST_FLOOR, {"a": (_robot(0.2, 0.05), (0.0, 0.0))}),
    "in a crate that is turned": (_CRATE, {"a": (_robot(0.6, 0.3), (0.0, 0.0))}),
    "in each other": ("", {"a": (_robot(0.4, 0.2), (0.0, 0.0)), "b": (_robot(0.4, 0.1), (0.3, 0.1))}),
    "in an unknown shape of the room": (_LOST, {"a": (_robot(0.4, 0.2), (1.7, 0.0))}),
    "unknown at its base, with a known tool above": ("", {"a": (_HOLDS, (0.0, 0.0))}),
    "known, in an unknown shape of the room": (_LOST, {"a": (_robot(0.2, 0.1, _KNOWN), (1.8, 0.0))}),
}


def _run(folder: Path, engine: str, room: str, robots: Robots) -> Run:
    bodies, poses = "", ""
    for name, (text, (x, y, *yaw)) in robots.items():
        (folder / f"{name}.sdf").write_text(text)
        bodies += f'<bodyModel robotId="{name}">{name}.sdf</bodyModel>'
        poses += f'<robotPose robotId="{name}" x="{x}" y="{y}" z="0" roll="0" pitch="0" yaw="{sum(yaw)}"/>'
    (folder / "x.bibi").write_text(f"<bibi>{bodies}</bibi>")
    (folder / "x.exc").write_text(
        f'<ExD><timeout>2</timeout><environmentModel src="room.sdf">{poses}</environmentModel>'
        '<bibiConf src="x.bibi"/></ExD>'
    )
    content = room if room == _LOST_FLOOR else _static("floor", "0 0 0 0 0 0", _FLOOR) + room
    (folder / "room.sdf").write_text(f'<sdf version="1.6"><world name="w">{content}</world></sdf>')
    return Run(read_exc(folder / "x.exc", [f"world.backend={engine}"]))


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
@pytest.mark.parametrize("case", CASES)
def test_a_robot_of_missing_meshes_stays_where_it_starts(tmp_path: Path, engine: str, case: str) -> None:
    room, robots = CASES[case]
    with _run(tmp_path, engine, room, robots) as run:
        starts = {name: run.world.model_motion(name) for name in robots}
        for start in starts.values():
            assert (start.linear, start.angular) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        run.run_until(0.02)
        for name in robots:
            assert hypot(*run.world.model_motion(name).linear) <= 9.81 * 0.02  # gravity alone
        run.run_until(1.0)
        for name, start in starts.items():
            pose = run.world.model_motion(name).pose
            assert dist(pose.position, start.pose.position) < 0.01
            w = (start.pose.inverse() @ pose).orientation[3]
            assert 2 * acos(min(1.0, abs(w))) < 0.02
