"""Delay, noise and drop-outs of topics that no sensor publishes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cart import BRAIN, CART, MOVING, ROOM, write
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.checks.validate import validate_file
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import InvalidExperimentError, Level
from nrp_core.messages.geometry_msgs import Pose, PoseWithCovariance, Quaternion
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.world.imperfection import with_noise
from nrp_core.world.topics import Stamped

JOINTS = "/cart/joint_states"
MODELS = "/gazebo/model_states"


def samples(folder: Path, sensors: str, world: str = "mujoco") -> list[list[Stamped]]:
    """The messages of both topics in 0.3 s, in which a force moves the cart."""
    changes = [f"world.sensors={sensors}", f"world.backend={world}", "transfer_functions=[]", "topics=null"]
    file = write(folder, experiment__yaml=MOVING, brain__py=BRAIN, room__sdf=ROOM, cart__sdf=CART)
    with Run(load_experiment(file, changes)) as run:
        topics = [run.world.subscribe(topic, depth=None) for topic in (JOINTS, MODELS)]
        run.publish("/model/cart/joint/slide/cmd_force", 10.0)
        found: list[list[Stamped]] = [[], []]
        while run.now_s < 0.3:
            run.step()
            for messages, topic in zip(found, topics, strict=True):
                messages += topic.take()
        return found


@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
def test_joint_states_come_as_late_as_they_should(world: str, tmp_path: Path) -> None:
    joints, models = samples(tmp_path, f"{{{JOINTS}: {{delay: 35 ms}}}}", world)
    exact, _ = samples(tmp_path, f"{{{MODELS}: {{noise: 0.1}}}}", world)
    true = {stamped.t_ns: stamped.message.position[0] for stamped in exact}
    assert len(models) == 15
    late = {stamped.t_ns - 35_000_000: stamped.message for stamped in joints}
    assert min(late) == 0
    assert all(message.header.stamp.to_ns() == t_ns for t_ns, message in late.items())
    both = sorted(late.keys() & true.keys())
    assert len(both) > 10
    assert [late[t_ns].position[0] for t_ns in both] == [true[t_ns] for t_ns in both]
    assert late[both[-1]].position[0] > 0


def test_noise_and_lost_messages_have_their_share_and_repeat(tmp_path: Path) -> None:
    settings_ = f"{{{JOINTS}: {{noise: 0.01, drop_out: 0.3}}, {MODELS}: {{noise: 0.1}}}}"
    joints, models = samples(tmp_path, settings_)
    again, _ = samples(tmp_path, settings_)
    assert [(one.t_ns, one.message.position[0]) for one in joints] == [
        (one.t_ns, one.message.position[0]) for one in again
    ]
    assert 85 < len(joints) < 125, "of 151 samples"
    velocities = np.array([stamped.message.effort[0] for stamped in joints])
    assert np.std(velocities[1:] - velocities[1]) > 0.001
    heights = [stamped.message.pose[0].position.z for stamped in models]
    assert 0.02 < np.std(heights) < 0.3


def test_a_topic_that_the_world_does_not_publish_is_refused(tmp_path: Path) -> None:
    file = write(tmp_path, experiment__yaml=MOVING, brain__py=BRAIN, room__sdf=ROOM, cart__sdf=CART)
    for topic in ("/cart/joint_state", "/u", "/tf", "/model/cart/joint/slide/cmd_force"):
        change = [f"world.sensors={{{topic}: {{delay: 1 ms}}}}", "transfer_functions=[]"]
        messages = [
            finding.message for finding in validate_file(file, change) if finding.level is Level.ERROR
        ]
        assert messages
        assert f"the world does not publish '{topic}'" in messages[0]


@settings(max_examples=30)
@given(st.lists(st.floats(-3, 3), min_size=3, max_size=3))
def test_a_noisy_orientation_turns_by_the_angles_and_stays_one(angles: list[float]) -> None:
    turned = with_noise(Quaternion(0.0, 0.0, 0.0, 1.0), lambda n: np.array(angles[:n]))
    assert np.linalg.norm([turned.x, turned.y, turned.z, turned.w]) == pytest.approx(1)
    angle = np.linalg.norm(angles)
    assert turned.w == pytest.approx(np.cos(angle / 2))


def test_noise_spares_covariances_and_stamps() -> None:
    drawn: list[int] = []

    def draw(n: int) -> Any:
        drawn.append(n)
        return np.ones(n)

    odometry = Odometry(pose=PoseWithCovariance(Pose()))
    noisy = with_noise(odometry, draw)
    assert noisy.pose.pose.position.y == noisy.twist.twist.linear.x == 1.0
    assert noisy.header == odometry.header
    assert np.array_equal(noisy.pose.covariance, odometry.pose.covariance)
    assert sum(drawn) == 12


EYE = """
<sdf version="1.9"><model name="eye"><static>true</static><link name="head"/></model></sdf>
"""


def test_a_static_robot_is_placed_and_gets_sensors_and_nothing_else(tmp_path: Path, golden: Golden) -> None:
    eye = f"{{model: {tmp_path}/eye.sdf, pose: [1, 2, 1, 0, 0, 0], add_sensors: [{{type: imu, link: head}}]"
    changes = ["transfer_functions=[]", "topics=null"]
    file = write(tmp_path, experiment__yaml=MOVING, brain__py=BRAIN, room__sdf=ROOM, cart__sdf=CART)
    (tmp_path / "eye.sdf").write_text(EYE)
    with Run(load_experiment(file, [*changes, f"world.robots.eye={eye}}}"])) as run:
        run.step()
        assert run.world.scene.model("eye").pose.position == (1, 2, 1)
        assert "/eye/head/imu/imu" in run.world.topics
    with golden.raises(InvalidExperimentError, match="never moves"):
        Run(load_experiment(file, [*changes, f"world.robots.eye={eye}, keyframe: home}}"]))
