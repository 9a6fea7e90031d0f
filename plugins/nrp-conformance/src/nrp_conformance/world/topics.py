"""Contract: the topics, their messages and timing, and the messages that they refuse."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from nrp_conformance.world.kit import (
    CAMERA_HZ,
    HEIGHT,
    RED,
    WIDTH,
    WorldKit,
    floor,
    robot,
    screen,
    states,
    twist,
)
from nrp_core.clock import SampleSchedule, from_seconds
from nrp_core.errors import TopicError
from nrp_core.messages.gazebo_msgs import ModelStates, WheelSpeeds
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.sensor_msgs import Image, JointState
from nrp_core.messages.std_msgs import ColorRGBA, Float64
from nrp_core.world.topics import Direction

SERVED = {
    "/gazebo/model_states": (ModelStates, Direction.OUT, None),
    "/robot/camera": (Image, Direction.OUT, CAMERA_HZ),
    "/robot/cmd_vel": (Twist, Direction.IN, None),
    "/robot/odom": (Odometry, Direction.OUT, 50.0),
    "/robot/wheel_speeds": (WheelSpeeds, Direction.BOTH, 50.0),
    "/robot/joint_states": (JointState, Direction.OUT, None),
    "/screen/link/visual/color": (ColorRGBA, Direction.BOTH, None),
}


class TopicTests(WorldKit):
    """Messages to and from a world."""

    @pytest.mark.parametrize("name", sorted(SERVED))
    def test_each_part_of_the_scene_has_topics_with_type_direction_and_rate(self, name: str) -> None:
        topic = self.open(floor(), robot(), screen("screen", 0.0, RED)).topics[name]
        assert (topic.type, topic.direction, topic.rate_hz) == SERVED[name]

    @pytest.mark.parametrize(("name", "rate"), [("/robot/odom", 50), ("/robot/wheel_speeds", 50)])
    def test_samples_come_at_their_rate_each_with_its_own_time(self, name: str, rate: int) -> None:
        if name.endswith("wheel_speeds"):
            self.require("dynamics")
        world = self.open(floor(), robot())
        subscription = world.subscribe(name, depth=100)
        self.run(world, 1.0)
        schedule = SampleSchedule(Fraction(rate), self.capabilities.step_ns)
        taken = [stamped.t_ns for stamped in subscription.since(-1)]
        assert taken == [schedule.sample_ns(k) for k in range(len(taken))]
        assert len(taken) == rate + 1  # one at time 0, one at 1 s

    def test_messages_carry_their_time_and_frame(self) -> None:
        world = self.open(floor(), robot())
        subscription = world.subscribe("/robot/odom", depth=9)
        self.run(world, 0.1)
        for stamped in subscription.since(-1):
            assert stamped.message.header.stamp.to_ns() == stamped.t_ns
            assert stamped.message.child_frame_id == "robot/base"

    def test_images_have_their_size_and_stamp_and_are_read_only(self) -> None:
        self.require_camera()
        world = self.open(floor(), robot(), screen("screen", 0.0, RED))
        subscription = world.subscribe("/robot/camera", depth=9)
        self.run(world, 0.1)
        first, *_ = messages = subscription.since(-1)
        message = first.message
        height, width, channels = message.data.shape
        assert [stamped.message.header.stamp.to_ns() for stamped in messages] == [s.t_ns for s in messages]
        assert (message.height, message.width, message.encoding, channels) == (height, width, "rgb8", 3)
        assert message.step == 3 * width
        assert height * WIDTH == width * HEIGHT  # an option may scale it
        with pytest.raises(ValueError, match="read-only"):
            message.data[0, 0, 0] = 7

    def test_an_old_image_does_not_change_when_a_new_one_is_taken(self) -> None:
        self.require_camera()
        world = self.open(floor(), robot(), screen("screen", 0.0, RED))
        subscription = world.subscribe("/robot/camera", depth=9)
        self.run(world, 0.01)
        first = subscription.since(-1)[0].message.data
        before = first.copy()
        world.advertise("/screen/link/visual/color").publish(ColorRGBA(0.0, 0.0, 1.0, 1.0))
        self.run(world, 0.2)
        assert np.array_equal(first, before)

    @pytest.mark.parametrize(
        "message",
        ["1.0", 1.0, Float64(1.0), Vector3(1.0), Twist(Vector3("fast"))],  # type: ignore[arg-type]
    )
    def test_a_message_of_another_type_is_refused_before_the_engine_sees_it(self, message: object) -> None:
        world = self.open(floor(), robot())
        commands = world.advertise("/robot/cmd_vel")
        with pytest.raises(TopicError):
            commands.publish(message)
        assert self._comes_to_rest_where_it_stands(world)

    @pytest.mark.parametrize("value", [float("nan"), float("inf")])
    def test_a_number_that_is_not_finite_is_refused_before_the_engine_sees_it(self, value: float) -> None:
        world = self.open(floor(), robot())
        with pytest.raises(TopicError):
            world.advertise("/robot/cmd_vel").publish(twist(value, 0.0))
        assert self._comes_to_rest_where_it_stands(world)

    def test_a_colour_out_of_range_is_refused(self) -> None:
        world = self.open(screen("screen", 0.0, RED))
        with pytest.raises(TopicError):
            world.advertise("/screen/link/visual/color").publish(ColorRGBA(2.0, 0.0, 0.0, 1.0))

    def test_unknown_topics_and_topics_of_the_opposite_direction_are_refused(self) -> None:
        world = self.open(floor(), robot())
        with pytest.raises(TopicError, match="cmd_vel"):
            world.advertise("/robot/cmd_vell")
        with pytest.raises(TopicError):
            world.subscribe("/robot/cmd_vel")
        with pytest.raises(TopicError):
            world.advertise("/robot/odom")

    def test_model_states_list_every_model_in_the_order_of_the_scene(self) -> None:
        world = self.open(floor(), robot("b", y=2.0), robot("a"))
        latest = world.subscribe("/gazebo/model_states").latest
        assert latest is not None
        assert latest.message.name == ["floor", "b", "a"]
        assert [pose.position.y for pose in latest.message.pose] == pytest.approx([0.0, 2.0, 0.0], abs=1e-6)
        assert latest.t_ns == 0

    def test_joints_are_listed_in_the_order_of_the_file(self) -> None:
        self.require("dynamics")
        world = self.open(floor(), robot())
        latest = world.subscribe("/robot/joint_states").latest
        assert latest is not None
        assert latest.message.name == ["back_left", "back_right", "front_left", "front_right"]

    def test_a_subscription_ends(self) -> None:
        world = self.open(floor(), robot())
        subscription = world.subscribe("/robot/odom", depth=50)
        self.run(world, 0.1)
        world.unsubscribe(subscription)
        self.run(world, 0.3)
        assert max(stamped.t_ns for stamped in subscription.since(-1)) <= from_seconds(0.1)

    def _comes_to_rest_where_it_stands(self, world: object) -> bool:
        self.run(world, 0.2)  # type: ignore[arg-type]
        x, y, _ = states(world)["robot"].pose.position  # type: ignore[arg-type]
        return abs(x) < 0.01 and abs(y) < 0.01
