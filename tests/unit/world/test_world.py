"""What the base of all worlds promises: topics, reset, snapshots, errors."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.errors import (
    CapabilityError,
    DivergedError,
    LifecycleError,
    SimulationError,
    TimestepError,
    TopicError,
)
from nrp_core.findings import Code, Finding, Level
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import ColorRGBA, Float64
from nrp_core.scene.model import Link, Model
from nrp_core.simulation import State
from nrp_core.world.switchboard import Switchboard
from nrp_core.world.topics import Direction
from nrp_core.world.world import World

MS = 1_000_000
FORWARD = Twist(Vector3(x=1.0), Vector3(z=0.3))
GLASS = "/screen/body/glass/color"


# -- topics


def test_every_topic_says_what_it_is(room: Any) -> None:
    directions = {name: info.direction for name, info in room.topics.items()}
    services = {name for name in directions if name.startswith("/gazebo/") and not name.endswith("_states")}
    assert {directions.pop(name) for name in services} == {Direction.IN}
    assert directions == {
        "/gazebo/model_states": Direction.OUT,
        "/gazebo/link_states": Direction.OUT,
        "/husky/camera": Direction.OUT,
        "/husky/base_link/deck/color": Direction.BOTH,
        GLASS: Direction.BOTH,
        "/husky/cmd_vel": Direction.IN,
        "/husky/odom": Direction.OUT,
        "/husky/wheel_speeds": Direction.BOTH,
        "/husky/joint_states": Direction.OUT,
    }
    assert room.topics["/husky/camera"].rate_hz == 30
    assert all(info.what for info in room.topics.values())


class Looking:
    """Looks first at a time, then after the periods that it is given."""

    def __init__(self, world: World, first_ns: int | None, *periods_ns: int) -> None:
        self.world, self.deadline_ns, self._periods_ns = world, first_ns, list(periods_ns)
        self.seen: list[tuple[int, float]] = []

    def observe(self, now_ns: int) -> None:
        self.seen.append((now_ns, self.world.model_motion("husky").pose.position[0]))
        self.deadline_ns = now_ns + self._periods_ns.pop(0) if self._periods_ns else None


def test_an_observer_of_physics_steps_looks_when_it_asks_for_it(room: Any) -> None:
    room.advertise("/husky/cmd_vel").publish(Twist(Vector3(x=1.0)))
    late, often = Looking(room, 12 * MS + 1, 50 * MS), Looking(room, 0, 0, 0)
    for observer in (late, often, Looking(room, None)):
        room.add_physics_observer(observer)
    room.run_until(20 * MS)
    first_ns = room.engine.step_ns
    assert [t_ns for t_ns, _ in often.seen] == [first_ns, 2 * first_ns, 3 * first_ns]
    ((t_ns, x),) = late.seen
    assert 12 * MS < t_ns < 12 * MS + 1 + first_ns
    assert 0 < x < room.model_motion("husky").pose.position[0]
    room.remove_physics_observer(late)
    room.run_until(100 * MS)
    assert len(late.seen) == 1


def test_an_unknown_topic_gets_a_suggestion(room: Any, golden: Golden) -> None:
    with golden.raises(TopicError, match="'/husky/cmd_val'.*'/husky/cmd_vel'"):
        room.advertise("/husky/cmd_val")
    with golden.raises(TopicError, match="'/husky/camara'.*'/husky/camera'"):
        room.subscribe("/husky/camara")
    with golden.raises(TopicError):
        room.advertise({"x": 1})


def test_a_topic_has_its_direction(room: Any, golden: Golden) -> None:
    with golden.raises(TopicError, match=r"'/husky/cmd_vel' \(geometry_msgs/msg/Twist\)"):
        room.subscribe("/husky/cmd_vel")
    with golden.raises(TopicError, match=r"'/husky/camera' \(sensor_msgs/msg/Image\)"):
        room.advertise("/husky/camera")


def test_a_wrong_message_is_refused_under_its_requested_name_without_side_effects(
    room: Any, golden: Golden
) -> None:
    room.add_alias("/go", "/husky/cmd_vel")
    go = room.advertise("/go")
    with golden.raises(TopicError):
        go.publish(Vector3())
    with golden.raises(TopicError, match=r"/go.*geometry_msgs/msg/Twist, angular\.z"):
        go.publish(Twist(angular=Vector3(z=nan)))
    go.publish(FORWARD)
    assert room.engine.velocity.forward == 1


def test_two_parts_must_not_serve_one_topic(room: Any, golden: Golden) -> None:
    husky, screen = room.scene.models
    other = replace(husky, name="other")
    with golden.raises(TopicError, match="'/husky/camera'"):
        World(type(room.engine)(replace(room.scene, models=(husky, other, screen))))


def test_only_parts_of_one_model_that_take_commands_alike_share_a_topic(room: Any) -> None:
    husky, screen = room.scene.models
    (drive,), topic = husky.drives, "/cmd_vel"
    alone = replace(drive, command_topic=topic, odometry_topic=None, wheel_speeds_topic=None)
    bare = Model("one", tuple(Link(one.name) for one in husky.links), husky.joints, drives=(alone,))
    robots = bare, replace(bare, name="two")
    both = replace(bare, name="both", drives=(alone, replace(alone, name="second")))
    with pytest.raises(TopicError, match="'/cmd_vel': velocity command of one and velocity command of two"):
        World(type(room.engine)(replace(room.scene, models=(husky, screen, *robots))))
    parts = World(type(room.engine)(replace(room.scene, models=(husky, screen, both)))).parts.of("both")
    board = Switchboard(room.engine, room)
    board.connect(parts[0], parts)
    parts[1].number_topics = frozenset()
    with pytest.raises(TopicError, match="'/cmd_vel'"):
        board.connect(parts[1], parts)


# -- aliases


def test_an_alias_is_the_topic_under_another_name(room: Any) -> None:
    room.add_alias("/screens/left/color", GLASS)
    assert room.topics["/screens/left/color"].type is ColorRGBA
    room.advertise("/screens/left/color").publish(ColorRGBA(1, 0, 0, 1))
    assert room.subscribe("/screens/left/color").latest.message.r == 1
    assert room.subscribe(GLASS).latest.message.r == 1


def test_an_alias_of_an_alias_is_the_same_topic(room: Any) -> None:
    room.add_alias("/a", GLASS)
    room.add_alias("/b", "/a")
    assert room.subscribe("/b").topic.name == GLASS


@pytest.mark.parametrize("name", [GLASS, "/taken", "relative"])
def test_a_name_is_given_once_and_absolute(room: Any, name: str, golden: Golden) -> None:
    room.add_alias("/taken", GLASS)
    for take in (lambda: room.add_alias(name, "/husky/camera"), lambda: room.declare(name, Float64)):
        with golden.raises(TopicError):
            take()


def test_an_alias_of_nothing_is_refused(room: Any, golden: Golden) -> None:
    with golden.raises(TopicError, match="'/screen/body/glas/color'"):
        room.add_alias("/left", "/screen/body/glas/color")


# -- topics of the user's own


def test_a_declared_topic_carries_what_is_published_on_it(room: Any) -> None:
    room.declare("/mine", Float64)
    mine = room.subscribe("/mine", depth=5)
    publication = room.advertise("/mine")
    assert mine.latest is None
    publication.publish(Float64(1))
    room.run_until(4 * MS)
    publication.publish(Float64(2))
    assert [(s.t_ns, s.message.data) for s in mine.messages] == [(0, 1), (4 * MS, 2)]


def test_a_message_that_its_sender_changes_later_arrives_as_it_was_sent(room: Any) -> None:
    room.declare("/mine", Float64)
    mine = room.subscribe("/mine", depth=5)
    message = Float64(1)
    room.advertise("/mine").publish(message)
    message.data = 2.0
    assert mine.latest.message.data == 1


def test_an_observer_sees_all_that_is_published(room: Any) -> None:
    seen: list[tuple[str, int]] = []

    def watch(topic: str, stamped: Any) -> None:
        seen.append((topic, stamped.t_ns))

    room.add_alias("/left", GLASS)
    room.add_observer(watch)
    room.run_until(2 * MS)
    room.advertise("/left").publish(ColorRGBA(1, 0, 0, 1))
    room.remove_observer(watch)
    room.advertise("/left").publish(ColorRGBA(0, 0, 0, 1))
    assert seen == [(GLASS, 2 * MS)]


# -- reset


def test_after_a_reset_everything_is_as_at_the_beginning(room: Any) -> None:
    images = room.subscribe("/husky/camera", depth=100)
    room.declare("/mine", Float64)
    mine = room.subscribe("/mine")

    def run() -> tuple[object, ...]:
        room.advertise("/husky/cmd_vel").publish(FORWARD)
        room.advertise(GLASS).publish(ColorRGBA(1, 0, 0, 1))
        room.advertise("/mine").publish(Float64(1))
        room.run_until(300 * MS)
        return room.engine.x, room.engine.y, room.engine.heading, [s.t_ns for s in images.messages]

    first = run()
    room.reset()
    assert (room.now_ns, images.latest, mine.latest, room.engine.steps) == (0, None, None, 0)
    assert room.engine.colors["screen/body/glass"] == (0, 0, 1, 1)
    assert room.engine.velocity.forward == 0
    assert run() == first


def test_a_command_of_before_the_reset_does_not_stop_one_of_after_it(room: Any) -> None:
    room.advertise("/husky/cmd_vel").publish(FORWARD)
    room.reset()
    room.run_until(60 * MS)
    room.advertise("/husky/cmd_vel").publish(FORWARD)
    room.run_until(140 * MS)
    assert room.engine.velocity.forward == 1


# -- snapshots


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(saved_at=st.integers(0, 100), ends_at=st.integers(0, 150))
def test_running_on_from_a_snapshot_equals_never_having_left(
    open_world: Any, saved_at: int, ends_at: int
) -> None:
    world = open_world()
    images = world.subscribe("/husky/camera", depth=100)
    world.declare("/mine", Float64)
    mine = world.subscribe("/mine", depth=3)
    world.advertise("/husky/cmd_vel").publish(FORWARD)
    world.run_until(saved_at * 2 * MS)
    world.advertise("/mine").publish(Float64(saved_at))
    world.advertise(GLASS).publish(ColorRGBA(1, 0, 0, 1))
    snapshot = world.snapshot()

    def run_on() -> tuple[object, ...]:
        world.run_until((saved_at + ends_at) * 2 * MS)
        held = [(s.t_ns, s.message.data.tolist()) for s in images.messages]
        return (
            world.engine.x,
            world.engine.y,
            world.engine.heading,
            world.engine.velocity,
            held,
            mine.messages,
            world.engine.colors,
        )

    left = run_on()
    world.advertise("/mine").publish(Float64(-1))
    world.advertise(GLASS).publish(ColorRGBA(0, 1, 0, 1))
    world.advertise("/husky/cmd_vel").publish(Twist(Vector3(x=-3)))
    world.run_until(1000 * MS)
    world.restore(snapshot)
    assert world.now_ns == saved_at * 2 * MS
    assert run_on() == left


def test_a_fresh_world_of_the_same_scene_takes_the_snapshot(open_world: Any) -> None:
    old, new = open_world(), open_world()
    old.advertise("/husky/cmd_vel").publish(FORWARD)
    old.run_until(50 * MS)
    new.restore(old.snapshot())
    for world in (old, new):
        world.run_until(200 * MS)
    assert (old.engine.x, old.engine.y) == (new.engine.x, new.engine.y)


def test_a_world_of_another_scene_does_not(open_world: Any, golden: Golden) -> None:
    with golden.raises(SimulationError):
        open_world(rate_hz=20.0).restore(open_world().snapshot())


def test_an_engine_without_snapshots_says_so_and_goes_on(open_world: Any, golden: Golden) -> None:
    world = open_world(snapshot=False)
    with golden.raises(CapabilityError, match="PointEngine"):
        world.snapshot()
    world.run_until(2 * MS)


# -- errors


def test_a_time_between_two_steps_is_refused_without_side_effects(room: Any, golden: Golden) -> None:
    with golden.raises(TimestepError):
        room.run_until(3 * MS)
    assert room.state is State.READY
    room.run_until(4 * MS)


def test_an_engine_that_loses_a_model_is_stopped_with_its_name(room: Any, golden: Golden) -> None:
    room.run_until(2 * MS)
    room.engine.x = nan
    with golden.raises(DivergedError, match="'husky'") as failure:
        room.run_until(4 * MS)
    assert failure.value.t_ns == 4 * MS
    assert room.state is State.FAILED
    room.reset()
    room.run_until(4 * MS)


def test_an_engine_that_raises_is_one_error_with_its_time(room: Any, golden: Golden) -> None:
    room.run_until(2 * MS)
    room.engine.fails = True
    with golden.raises(SimulationError, match=r"PointEngine.*0\.002.*ZeroDivisionError"):
        room.run_until(4 * MS)
    with golden.raises(LifecycleError):
        room.advertise("/husky/cmd_vel").publish(FORWARD)


def test_a_closed_world_has_no_topics(room: Any, golden: Golden) -> None:
    color, command = room.subscribe(GLASS), room.advertise("/husky/cmd_vel")
    room.close()
    for use in (
        lambda: room.subscribe(GLASS),
        lambda: room.advertise(GLASS),
        lambda: color.latest,
        lambda: command.publish(FORWARD),
        lambda: room.run_until(2 * MS),
    ):
        with golden.raises(LifecycleError):
            use()


def test_the_warnings_of_the_scene_are_the_worlds(room: Any) -> None:
    finding = Finding(Code.NRP264, "careful", Level.WARNING, Path("room.sdf"), 3)
    warned = replace(room.scene, warnings=(finding,))
    assert World(type(room.engine)(warned)).warnings == [finding]


def test_a_world_that_cannot_change_gets_its_lights_back_by_a_reset_or_a_snapshot(room: Any) -> None:
    before = room.snapshot()
    room.set_lights(())
    dark = room.snapshot()
    room.reset()
    assert [light.name for light in room.scene.lights] == ["sun"]
    room.restore(dark)
    assert room.scene.lights == ()
    room.restore(before)
    assert [light.name for light in room.scene.lights] == ["sun"]


def test_a_world_that_cannot_change_cannot_reset_its_state_while_time_goes_on(
    room: Any, golden: Golden
) -> None:
    with golden.raises(CapabilityError):
        room.reset("state")
