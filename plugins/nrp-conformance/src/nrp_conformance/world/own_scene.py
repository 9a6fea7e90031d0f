"""The tests for worlds with a scene of their own: a file that only this engine reads, or a fixed environment.

Nothing is known of such a scene but its topics. So these tests ask what holds for any: the clock, commands,
snapshots, resets, determinism and errors. They do not ask whether bodies move as they should: compare that
with the program that the world wraps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction
from functools import partial
from math import isfinite, nan
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import rule

from nrp_conformance.base import skip_undeclared
from nrp_conformance.sequences import SequenceMachine, check_sequences
from nrp_conformance.world.kit import WorldKit, floor, robot
from nrp_core.clock import SampleSchedule
from nrp_core.errors import (
    CapabilityError,
    LifecycleError,
    NrpError,
    SnapshotError,
    TimestepError,
    TopicError,
)
from nrp_core.messages.std_msgs import String
from nrp_core.scene.rigid import Pose
from nrp_core.simulation import Determinism
from nrp_core.world import WORLD_INTERFACE_VERSION, Direction, Scene, TopicInfo, World, read_scene

STEPS = 25
"""The steps of most runs, each of the engine's own length."""


class OwnSceneTests(WorldKit):
    """The tests for every world that brings its scene.

    Attributes:
        scene: the file of the scene; empty for a world that needs none.
    """

    scene: ClassVar[str] = ""

    # -- time

    def test_a_fresh_world_is_at_time_zero(self) -> None:
        world = self.fresh(seed=9)
        assert (world.now_ns, world.seed) == (0, 9)
        assert self.backend.interface_version == WORLD_INTERFACE_VERSION

    def test_a_run_ends_exactly_at_the_requested_time(self) -> None:
        world = self.fresh()
        seen = _subscribe(world)
        for steps in (1, 2, 5, 6):
            self._advance(world, steps - world.now_ns // self.capabilities.step_ns)
            assert world.now_ns == steps * self.capabilities.step_ns
            latest = {name: each.latest for name, each in seen.items() if world.topics[name].rate_hz is None}
            assert all(one is None or one.t_ns <= world.now_ns for one in latest.values())

    def test_time_does_not_run_backwards_and_stops_only_on_the_grid(self) -> None:
        world = self.fresh()
        self._advance(world, 10)
        with pytest.raises(LifecycleError):
            world.run_until(5 * self.capabilities.step_ns)
        with pytest.raises(TimestepError):
            world.run_until(world.now_ns + self.capabilities.step_ns // 2 + 1)

    def test_samples_come_at_their_rate_each_with_its_own_time(self) -> None:
        world = self.fresh()
        timed = {topic.name: topic.rate_hz for topic in _observed(world) if topic.rate_hz is not None}
        if not timed:
            skip_undeclared("topics with a rate")
        seen = {name: world.subscribe(name, depth=1000) for name in timed}
        self._advance(world, STEPS)
        for name, rate_hz in timed.items():
            schedule = SampleSchedule(Fraction(rate_hz), self.capabilities.step_ns)
            taken = [stamped.t_ns for stamped in seen[name].since(-1)]
            assert taken == [schedule.sample_ns(k) for k in range(len(taken))], name
            assert schedule.sample_ns(len(taken)) > world.now_ns, name

    # -- determinism

    def test_two_runs_are_equal(self) -> None:
        self.require_repeatable()
        assert self._driven(self.fresh()) == self._driven(self.fresh())

    def test_two_worlds_in_one_process_do_not_disturb_each_other(self) -> None:
        self.require_repeatable()
        expected = self._driven(self.fresh())
        one, two = self.fresh(), self.fresh()
        seen, _ = _subscribe(one), _subscribe(two)
        for step in range(STEPS):
            self._go(one, step)
            self._go(two, step + 100)
        assert _read(seen) == expected

    def test_splitting_a_run_is_invisible(self) -> None:
        self.require_repeatable()
        ends = []
        for cut in (STEPS, 1, 7):
            world = self.fresh()
            seen = _subscribe(world)
            self._command_all(world, 1)
            for start in range(0, STEPS, cut):
                self._advance(world, min(cut, STEPS - start))
            ends.append(_read(seen))
        assert ends[0] == ends[1] == ends[2]

    def test_reading_changes_nothing(self) -> None:
        self.require_repeatable()
        expected = self._driven(self.fresh())
        world = self.fresh()
        seen = _subscribe(world)
        for step in range(STEPS):
            self._go(world, step)
            _read(seen)
            self._poses(world)
        assert _read(seen) == expected

    # -- commands

    def test_something_can_be_observed(self) -> None:
        world = self.fresh()
        seen = _subscribe(world)
        self._advance(world, STEPS)
        assert seen
        assert all(each.latest is not None for each in seen.values())

    def test_every_command_changes_what_the_world_publishes(self) -> None:
        self.require_repeatable()
        world = self.fresh()
        names = self._commands(world)
        if not names:
            skip_undeclared("topics with commands of numbers")
        self.note("topics_commanded", len(names))
        seen = _subscribe(world)
        silent = self._after_reset(world, lambda: None, seen)
        for name in names:
            shares = (0.0, 1.0, 0.5)
            changed = (
                self._after_reset(world, partial(self._command, world, name, each), seen) for each in shares
            )
            assert any(each != silent for each in changed), name

    def test_a_message_of_another_type_is_refused_before_the_engine_sees_it(self) -> None:
        self._check_refused(lambda _: String("1.0"))

    @pytest.mark.parametrize("value", [nan, float("inf")])
    def test_a_number_that_is_not_finite_is_refused_before_the_engine_sees_it(self, value: float) -> None:
        self._check_refused(lambda topic: _filled(topic, value), of=float)

    def test_a_number_out_of_range_is_refused_or_clipped(self) -> None:
        world = self.fresh()
        limited = [world.topics[name] for name in self._commands(world) if world.topics[name].limits]
        if not limited:
            skip_undeclared("limits of commands")
        for topic in limited:
            assert topic.limits is not None
            beyond = _filled(topic, topic.limits[1] + 1)
            if topic.clips:
                world.advertise(topic.name).publish(beyond)
            else:
                with pytest.raises(TopicError):
                    world.advertise(topic.name).publish(beyond)

    def test_unknown_topics_and_topics_of_the_opposite_direction_are_refused(self) -> None:
        world = self.fresh()
        with pytest.raises(TopicError):
            world.subscribe("/no/such/topic")
        for topic in world.topics.values():
            if topic.direction is Direction.IN:
                with pytest.raises(TopicError):
                    world.subscribe(topic.name)
            elif topic.direction is Direction.OUT:
                with pytest.raises(TopicError):
                    world.advertise(topic.name)

    # -- state

    @pytest.mark.parametrize("silent", [False, True])
    def test_a_reset_world_equals_a_fresh_one(self, silent: bool) -> None:
        self.require_repeatable()
        world = self.fresh()
        expected = self._driven(world, silent=silent)
        self._driven(world, 7, start=40)
        world.reset()
        assert world.now_ns == 0
        assert self._driven(world, silent=silent) == expected

    @pytest.mark.parametrize("silent", [False, True])
    def test_a_snapshot_decides_the_future(self, silent: bool) -> None:
        self.require_snapshot()
        self.require_repeatable()
        world, fresh = self.fresh(), self.fresh()
        self._driven(world, 8)
        snapshot, left_ns = world.snapshot(), world.now_ns
        expected = self._driven(world, start=8, silent=silent)
        for again in (world, fresh):
            again.restore(snapshot)
            assert again.now_ns == left_ns
            assert self._driven(again, start=8, silent=silent) == expected

    def test_an_undeclared_snapshot_is_refused(self) -> None:
        if self.capabilities.snapshot:
            skip_undeclared("a world without snapshots")
        with pytest.raises(CapabilityError):
            self.fresh().snapshot()

    def test_a_snapshot_of_another_scene_is_refused(self) -> None:
        self.require_snapshot()
        world = self.fresh()
        if not world.scene.models:
            skip_undeclared("models in the scene")
        first, *others = world.scene.models
        moved = replace(world.scene, models=(replace(first, pose=Pose((1.0, 2.0, 3.0))), *others))
        with pytest.raises(SnapshotError):
            self._open(moved).restore(world.snapshot())

    # -- bodies and errors

    def test_bodies_have_poses_and_joints_have_states(self) -> None:
        world = self.fresh()
        if not (self.capabilities.poses and world.scene.models):
            skip_undeclared("poses of models")
        self._driven(world)
        assert all(isfinite(number) for number in self._poses(world))
        for model in world.scene.models:
            if self.capabilities.dynamics and not model.static:
                states = world.joint_states(model.name)
                assert set(states.names) <= {joint.name for joint in model.joints}
                assert np.isfinite(states.positions).all()

    def test_robots_that_it_cannot_move_are_refused(self) -> None:
        with pytest.raises(NrpError):
            self.open(floor(), robot())

    def test_a_closed_world_refuses_every_call_and_leaves_others_running(self) -> None:
        world, other = self.fresh(), self.fresh()
        self._advance(world, 2)
        world.close()
        world.close()
        for attempt in (lambda: self._advance(world, 1), world.reset, world.snapshot):
            with pytest.raises(LifecycleError):
                attempt()
        self._advance(other, 3)
        assert other.now_ns == 3 * self.capabilities.step_ns

    # -- helpers

    def fresh(self, seed: int = 1) -> World:
        """Open the world at time 0; it is closed after the test."""
        return self._open(read_scene(Path(self.scene)) if self.scene else Scene(()), seed)

    def _open(self, scene: Scene, seed: int = 1) -> World:
        return self.opened.enter_context(self.backend.open(scene, seed=seed, options=self.chosen))

    def _advance(self, world: World, steps: int) -> None:
        world.run_until(world.now_ns + steps * self.capabilities.step_ns)

    def _driven(self, world: World, steps: int = STEPS, start: int = 0, *, silent: bool = False) -> object:
        """Return what a world publishes after steps that depend only on their numbers."""
        seen = _subscribe(world)
        for step in range(start, start + steps):
            self._go(world, step, silent=silent)
        found = _read(seen)
        for each in seen.values():
            world.unsubscribe(each)
        return found

    def _go(self, world: World, step: int, *, silent: bool = False) -> None:
        if not silent:
            self._command_all(world, step)
        self._advance(world, 1)

    def _commands(self, world: World) -> list[str]:
        return command_topics(world)

    def _command_all(self, world: World, step: int) -> None:
        for i, name in enumerate(self._commands(world)):
            self._command(world, name, (7 * i + 3 * step) % 11 / 10)

    def _command(self, world: World, name: str, share: float) -> None:
        """Publish a command at a share of the way between the limits of its topic."""
        topic = world.topics[name]
        low, high = topic.limits or (-1.0, 1.0)
        world.advertise(name).publish(_filled(topic, low + share * (high - low)))

    def _after_reset(self, world: World, command: Callable[[], None], seen: Any) -> object:
        world.reset()
        command()
        self._advance(world, STEPS)
        return _read(seen)

    def _check_refused(self, message: Callable[[TopicInfo], object], of: type | None = None) -> None:
        world, expected = self.fresh(), self._driven(self.fresh(), silent=True)
        topics = [world.topics[name] for name in self._commands(world)]
        asked = [topic for topic in topics if of is None or isinstance(_value_of(topic), of | np.ndarray)]
        if not asked:
            skip_undeclared("topics with commands of numbers")
        for topic in asked:
            with pytest.raises(TopicError):
                world.advertise(topic.name).publish(message(topic))
        if self.capabilities.determinism is not Determinism.STATISTICAL:
            assert self._driven(world, silent=True) == expected

    def _poses(self, world: World) -> Iterator[float]:
        """Yield the numbers of the poses of all models, and of their links if the world knows them."""
        for model in world.scene.models if self.capabilities.poses else ():
            motions = [world.model_motion(model.name)]
            if self.capabilities.links:
                motions += [world.link_motion(model.name, link.name) for link in model.links]
            for motion in motions:
                yield from (*motion.pose.position, *motion.pose.orientation)


class FullOwnSceneTests(OwnSceneTests):
    """Also calls in random order."""

    level = "sequences"

    def test_any_sequence_of_calls_has_one_meaning(self) -> None:
        self.require_repeatable()
        check_sequences(partial(_OwnSceneMachine, self), examples=5, length=10)


class _OwnSceneMachine(SequenceMachine):
    """Commands while a world runs, is reset and is restored."""

    def __init__(self, tests: FullOwnSceneTests) -> None:
        self._tests = tests
        super().__init__(can_restore=tests.capabilities.snapshot, step_ns=tests.capabilities.step_ns)

    def fresh(self) -> World:
        return self._tests.fresh(seed=3)

    def apply(self, simulation: World, name: str, value: Any) -> None:
        self._tests._command_all(simulation, value)

    def observed(self, simulation: World) -> object:
        seen = {topic.name: simulation.subscribe(topic.name) for topic in _observed(simulation)}
        found = {name: each for name, each in seen.items() if simulation.topics[name].rate_hz is None}
        return _read(found), list(self._tests._poses(simulation))

    @rule(step=st.integers(0, 10))
    def command(self, step: int) -> None:
        self.do("command", step)


def command_topics(world: World) -> list[str]:
    """Return the topics whose commands are numbers, or arrays whose elements have names."""
    taken = [one for one in world.topics.values() if one.direction is Direction.IN and one.response is None]
    return [
        topic.name
        for topic in taken
        if isinstance(value := _value_of(topic), float | int)
        or (isinstance(value, np.ndarray) and topic.elements)
    ]


def _observed(world: World) -> list[TopicInfo]:
    return [topic for topic in world.topics.values() if Direction.OUT in topic.direction]


def _subscribe(world: World) -> dict[str, Any]:
    return {topic.name: world.subscribe(topic.name) for topic in _observed(world)}


def _read(seen: dict[str, Any]) -> object:
    """Return the latest messages as values that can be compared, bit by bit."""
    return {
        name: None if each.latest is None else (each.latest.t_ns, _plain(each.latest.message))
        for name, each in seen.items()
    }


def _plain(value: Any) -> object:
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if is_dataclass(value):
        return tuple(_plain(getattr(value, each.name)) for each in fields(value))
    if isinstance(value, list | tuple):
        return tuple(_plain(each) for each in value)
    return value.hex() if isinstance(value, float) else value


def _value_of(topic: TopicInfo) -> Any:
    """Return the default of the one value that a message of a topic holds, or None."""
    return getattr(topic.type(), "data", None)


def _filled(topic: TopicInfo, value: float) -> Any:
    """Return a message whose numbers have a value."""
    made, default = topic.type(), _value_of(topic)
    if isinstance(default, np.ndarray):
        made.data = np.full(len(topic.elements), value)
    else:
        made.data = type(default)(value if isinstance(default, float) else round(value))
    return made
