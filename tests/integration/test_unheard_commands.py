"""Commands that nothing subscribes to, sent to real engines."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import nrp_experiments
import pytest

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, Finding, Weight

SHIPPED = Path(nrp_experiments.__file__).parent / "braitenberg_husky"
EXPERIMENT = f"""
name: unheard
timestep: 20 ms
duration: 0.5 s
strict: false
transfer_functions: [drive.py]
brain: {{backend: event, model: {SHIPPED}/brain.py, populations: {{sensors: "0:5", actors: "6:8"}}}}
world:
  backend: mujoco
  scene: {SHIPPED}/room.sdf
  robots: {{husky: {{model: {SHIPPED}/husky.sdf, pose: [0, 0, 0.2, 0, 0, 0]}}}}
"""
DRIVE = """
@nrp.Neuron2Robot(Topic('{topic}', geometry_msgs.msg.Twist))
def drive(t):
    return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=1.0))
"""
Drive = Callable[[str], tuple[list[Finding], float]]
MESSAGE = "nothing subscribes to '{topic}', so its commands have no effect{hint}"


@pytest.fixture(params=["mujoco", "pybullet"])
def drive(request: pytest.FixtureRequest, tmp_path: Path) -> Drive:
    """Return a function that commands a speed of 1 m/s on a topic, in one of the engines.

    It returns the findings about unheard commands, and how far the robot came, m.
    """

    def run(topic: str) -> tuple[list[Finding], float]:
        (tmp_path / "drive.py").write_text(DRIVE.format(topic=topic))
        (tmp_path / "experiment.yaml").write_text(EXPERIMENT)
        with Run(load_experiment(tmp_path, [f"world.backend={request.param}"])) as simulation:
            simulation.run(0.5)
            found = [one for one in simulation.problems if one.code is Code.NRP212]
            return found, simulation.world.engine.model_motion("husky").pose.position[0]

    return run


@pytest.mark.parametrize(
    ("topic", "hint"), [("/husky/cmd_vell", "; did you mean '/husky/cmd_vel'?"), ("/arm/effort", "")]
)
def test_a_command_that_nothing_subscribes_to_is_reported_at_the_function_that_publishes_it(
    drive: Drive, tmp_path: Path, topic: str, hint: str
) -> None:
    (finding,), x_m = drive(topic)
    assert finding.message == MESSAGE.format(topic=topic, hint=hint)
    assert (finding.subject, finding.path, finding.line) == (topic, tmp_path / "drive.py", 2)
    assert finding.weight is Weight.ALTERED
    assert abs(x_m) < 0.01


def test_a_command_that_reaches_the_drive_is_not_reported(drive: Drive) -> None:
    found, x_m = drive("/husky/cmd_vel")
    assert found == []
    assert x_m > 0.2
