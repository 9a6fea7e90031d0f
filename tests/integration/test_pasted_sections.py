"""The section that ``nrp inspect ROBOT`` prints is pasted as it stands, and moves the robot."""

from __future__ import annotations

from math import cos, sin
from pathlib import Path

import pytest

from nrp_core import Run, load_experiment
from nrp_core.cli import app
from nrp_core.messages.geometry_msgs import Quaternion
from nrp_core.messages.std_msgs import Float64

LINK = '<link name="{}"><inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
ENDS = '<parent link="{}"/><child link="{}"/>'
LIMIT = '<limit lower="-1" upper="1" effort="90" velocity="5"/>'
XACRO = f"""<robot name="true" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:arg name="on" default=""/>
{LINK.format("no", 1)}{LINK.format("off", "$(arg on)")}{LINK.format("tip", 1)}
<joint name="null" type="continuous">{ENDS.format("no", "off")}</joint>
<joint name="it's a: joint #1" type="revolute">{ENDS.format("off", "tip")}{LIMIT}</joint></robot>"""
SLIDE = f"""<robot name="5-slides">{LINK.format("base", 1)}{LINK.format("slide", 1)}
<joint name="1.0" type="prismatic">{ENDS.format("base", "slide")}{LIMIT}</joint></robot>"""
MESHED = SLIDE.replace(
    '<link name="base">',
    '<link name="base"><visual><geometry><mesh filename="model://parts/a.stl"/></geometry></visual>',
)
MJCF = """<mujoco><worldbody><body name="arm"><joint name="up" axis="0 1 0" range="-60 60"/>
<geom size="0.1"/></body></worldbody></mujoco>"""
BALL = """<sdf version="1.9"><model name="pendulum"><link name="base"/><link name="bob"/>
<joint name="held" type="fixed"><parent>world</parent><child>base</child></joint>
<joint name="neck" type="ball"><parent>base</parent><child>bob</child></joint></model></sdf>"""
EXPERIMENT = """name: pasted
duration: 1 s
brain: {{backend: event, model: brain.py}}
{models}
world:
  backend: {engine}
  scene: room.sdf
{section}
"""
BRAIN = """import nrp_core.pynn as sim
sim.setup(timestep=1.0)
cells = sim.Population(1, sim.IF_curr_exp(), label="cells")
"""
HALF = Quaternion(x=sin(0.25), w=cos(0.25))
"""A turn of 0.5 rad about x."""
ROOM = '<sdf version="1.9"><world name="room"/></sdf>'


@pytest.mark.one_of(6)
@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
@pytest.mark.parametrize(
    ("file", "content", "options"),
    [
        ("a #1: arm.urdf.xacro", XACRO, ["-s", "args.on=2"]),
        ("5.urdf", SLIDE, []),
        ("slide.urdf", MESHED, ["--models", "my parts, 2"]),
        ("arm.xml", MJCF, []),
        ("pendulum.sdf", BALL, []),
    ],
)
def test_the_output_of_inspect_is_valid_and_every_joint_takes_commands(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    file: str,
    content: str,
    options: list[str],
    engine: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)
    (tmp_path / "my parts, 2" / "parts").mkdir(parents=True)
    triangle = "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "my parts, 2" / "parts" / "a.stl").write_text(f"solid a\n{triangle}endsolid\n")
    for name, text in (("brain.py", BRAIN), ("room.sdf", ROOM), (file, content)):
        (tmp_path / name).write_text(text)
    assert app.run_app(["inspect", file, *options]) == 0
    head, section = capsys.readouterr().out.split(":\n  robots:\n")
    models = head.rsplit("'", 4)[1] if options[:1] == ["--models"] else ""
    text = EXPERIMENT.format(engine=engine, models=models, section=f"  robots:\n{section}")
    (tmp_path / "pasted.yaml").write_text(text)
    assert app.run_app(["validate", "pasted.yaml"]) == 0
    assert "is not there" not in capsys.readouterr().err
    with Run(load_experiment("pasted.yaml")) as run:
        world = run.world
        (robot,) = (model for model in world.scene.models if not model.static)
        kinds = {joint.name: joint.kind for joint in robot.joints if joint.kind != "fixed"}
        assert {each.joint: each.kind for each in robot.controllers} == {
            name: "velocity" if kind == "continuous" else "position" for name, kind in kinds.items()
        }
        for each in robot.controllers:
            ball = kinds[each.joint] == "ball"
            world.advertise(each.topic).publish(HALF if ball else Float64(0.5))
        run.run()
        states = world.joint_states(robot.name)
    for name, position, velocity in zip(states.names, states.positions, states.velocities, strict=True):
        if kinds.get(name) == "continuous":
            assert velocity == pytest.approx(0.5, rel=0.01)
        else:
            assert position == pytest.approx(0.0 if name.endswith(("_y", "_z")) else 0.5, abs=2e-3), name
