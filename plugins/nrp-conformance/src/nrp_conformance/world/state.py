"""Contract: a reset world equals a new one, a restored one continues exactly, after any sequence of calls."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import rule

from nrp_conformance.sequences import SequenceMachine, check_sequences
from nrp_conformance.world.kit import (
    BLUE,
    RED,
    WorldKit,
    at,
    floor,
    paint,
    pendulum,
    prop,
    robot,
    screen,
    states,
    twist,
)
from nrp_core.errors import LifecycleError, SnapshotError, TimestepError
from nrp_core.world import WORLD_INTERFACE_VERSION, Box, Model, Rgba, Scene, Sphere, World


def busy() -> tuple[Model, ...]:
    """Return a scene in which objects soon touch each other."""
    return (
        floor(), robot(), robot("other", 0.2, 1.5),
        prop("box", Box((0.3, 0.3, 0.3)), at(0.7, 0.05, 0.2), mass=1.0),
        prop("ball", Sphere(0.15), at(-1, 0, 0.5), mass=1.0),
        pendulum(), screen("screen", 0.0, BLUE),
    )  # fmt: skip


class StateTests(WorldKit):
    """A state contains everything that the future depends on."""

    def test_a_reset_world_equals_a_fresh_one(self) -> None:
        self.require_repeatable()
        world = self._open_busy()
        expected = self._driven_states(world, 20)
        self._driven_states(world, 7, start=20)
        world.reset()
        assert world.now_ns == 0
        assert self._driven_states(world, 20) == expected

    def test_a_reset_world_without_commands_equals_a_fresh_one(self) -> None:
        """Without commands, the state of contacts and motors in the engine shows."""
        self.require_repeatable()
        expected = self._driven_states(self._open_busy(), 5, silent=True)
        world = self._open_busy()
        self._driven_states(world, 3, silent=True)
        world.reset()
        assert self._driven_states(world, 5, silent=True) == expected

    def test_a_reset_restores_the_first_colours(self) -> None:
        self.require_camera()
        world = self._open_busy()
        before = self.image_of(world)
        paint(world, "screen/link/visual", RED)
        self.image_of(world)
        world.reset()
        assert np.array_equal(self.image_of(world), before)

    def test_a_reset_stops_the_robots(self) -> None:
        world = self.open(floor(), robot())
        self.drive(world, 0.8, 0.0, 0.3)
        world.reset()
        self.run(world, 0.3)
        assert world.model_motion("robot").pose.position[:2] == pytest.approx((0.0, 0.0), abs=0.01)

    def test_two_runs_are_equal(self) -> None:
        self.require_repeatable()
        assert self._driven_states(self._open_busy(), 25) == self._driven_states(self._open_busy(), 25)

    def test_two_worlds_in_one_process_do_not_disturb_each_other(self) -> None:
        self.require_repeatable()
        expected = self._driven_states(self._open_busy(), 15)
        one, two = self._open_busy(), self._open_busy()
        for step in range(15):
            self._go(one, step)
            self._go(two, step + 100)
        assert states(one) == expected
        assert states(two) != expected

    def test_splitting_a_run_is_invisible(self) -> None:
        self.require_repeatable()
        ends = []
        for n_cuts in (0, 1, 9):
            world = self._open_busy()
            world.advertise("/robot/cmd_vel").publish(twist(0.8, 0.5))
            for cut in sorted(np.random.default_rng(3).uniform(0.0, 0.5, n_cuts)):
                self.run(world, cut)
            self.run(world, 0.5)
            ends.append(states(world))
        assert ends[0] == ends[1] == ends[2]

    def test_a_run_ends_exactly_at_the_requested_time(self) -> None:
        self.require("dynamics")
        world = self.open(prop("ball", Sphere(0.1), at(0, 0, 10), mass=1.0))
        step_ns = self.capabilities.step_ns
        speeds = []
        for steps in (1, 2, 5, 6):
            world.run_until(steps * step_ns)
            assert world.now_ns == steps * step_ns
            speeds.append(-world.model_motion("ball").linear[2])
        assert speeds == pytest.approx([n * speeds[0] for n in (1, 2, 5, 6)], rel=1e-6)

    def test_reading_and_rendering_change_nothing(self) -> None:
        self.require_repeatable()
        expected = self._driven_states(self._open_busy(), 15)
        world = self._open_busy()
        world.subscribe("/robot/odom")
        images = [world.subscribe("/robot/camera")] if self.capabilities.renderers else []
        for step in range(15):
            self._go(world, step)
            states(world)
            if self.capabilities.dynamics:
                world.joint_states("robot")
        assert states(world) == expected
        assert all(each.latest is not None for each in images)

    def test_a_snapshot_keeps_everything_that_moves(self) -> None:
        self._check_continuation(lambda _: None)

    def test_a_snapshot_keeps_a_command_and_its_timeout(self) -> None:
        def command(world: World) -> None:
            world.advertise("/other/cmd_vel").publish(twist(0.4, -1.0))

        self._check_continuation(command, steps=25, silent=True)

    def test_a_snapshot_keeps_colours(self) -> None:
        self.require_snapshot()
        self.require_camera()
        world, fresh = self._open_busy(), self._open_busy()
        paint(world, "screen/link/visual", RED)
        snapshot, image = world.snapshot(), self.image_of(world)
        paint(world, "screen/link/visual", BLUE)
        self.image_of(world)
        for again in (world, fresh):
            again.restore(snapshot)
            assert np.array_equal(self.image_of(again), image)

    def test_a_snapshot_of_another_scene_is_refused(self) -> None:
        self.require_snapshot()
        snapshot = self.open(floor(), robot()).snapshot()
        with pytest.raises(SnapshotError):
            self.open(floor(), robot(x=1.0)).restore(snapshot)

    def test_a_fresh_world_is_at_time_zero_in_the_poses_of_its_scene(self) -> None:
        world = self._open_busy(seed=9)
        assert (world.now_ns, world.seed) == (0, 9)
        assert self.backend.interface_version == WORLD_INTERFACE_VERSION
        for model in world.scene.models:
            assert world.model_motion(model.name).pose.position == pytest.approx(
                model.pose.position, abs=1e-6
            )

    def test_time_does_not_run_backwards_and_stops_only_on_the_grid(self) -> None:
        world = self.open(floor(), robot())
        self.run(world, 0.1)
        with pytest.raises(LifecycleError):
            self.run(world, 0.05)
        with pytest.raises(TimestepError):
            world.run_until(world.now_ns + self.capabilities.step_ns // 2 + 1)

    def test_a_closed_world_refuses_every_call_and_leaves_others_running(self) -> None:
        world, other = self.open(floor(), robot()), self.open(floor(), robot())
        self.run(world, 0.1)
        world.close()
        world.close()
        for attempt in (lambda: self.run(world, 0.2), world.reset, world.snapshot):
            with pytest.raises(LifecycleError):
                attempt()
        self.drive(other, 0.5, 0.0, 0.5)
        assert other.model_motion("robot").pose.position[0] > 0.1

    def _open_busy(self, seed: int = 1) -> World:
        return self.open(*self.movable(*busy()), seed=seed)

    def _check_continuation(
        self, setup: Callable[[World], None], *, steps: int = 12, silent: bool = False
    ) -> None:
        """Check that a restored run equals an uninterrupted one, also in another world."""
        self.require_snapshot()
        self.require_repeatable()
        world, fresh = self._open_busy(), self._open_busy()
        self._driven_states(world, 8)
        setup(world)
        snapshot, left_ns, start = world.snapshot(), world.now_ns, states(world)
        expected = self._driven_states(world, steps, start=8, silent=silent)
        for again in (world, fresh):
            again.restore(snapshot)
            assert again.now_ns == left_ns
            assert states(again) == start
            assert self._driven_states(again, steps, start=8, silent=silent) == expected

    def _driven_states(self, world: World, steps: int, start: int = 0, *, silent: bool = False) -> object:
        for step in range(start, start + steps):
            self._go(world, step, silent=silent)
        return states(world)

    def _go(self, world: World, step: int, *, silent: bool = False) -> None:
        """Take a step that depends only on its number."""
        if not silent:
            world.advertise("/robot/cmd_vel").publish(twist(0.6, 0.2 * (step % 5 - 2)))
            world.advertise("/other/cmd_vel").publish(twist(-0.3, 0.1 * (step % 3)))
        world.run_until(world.now_ns + self.grid_ns(0.02))


class SequenceTests(WorldKit):
    """Calls in random order."""

    level = "sequences"

    def test_any_sequence_of_calls_has_one_meaning(self) -> None:
        self.require_repeatable()
        check_sequences(partial(_WorldMachine, self), examples=5, length=10)


class _WorldMachine(SequenceMachine):
    """Commands and paints while a world runs, is reset and is restored."""

    def __init__(self, kit: WorldKit) -> None:
        self._kit = kit
        super().__init__(can_restore=kit.capabilities.snapshot, step_ns=5 * kit.capabilities.step_ns)

    def fresh(self) -> World:
        scene = Scene(self._kit.movable(*busy()))
        world = self._kit.backend.open(scene, seed=3, options=self._kit.chosen)
        world.subscribe("/robot/odom", depth=1000)
        return world

    def apply(self, simulation: World, name: str, value: Any) -> None:
        if name == "paint":
            paint(simulation, "screen/link/visual", value)
        else:
            simulation.advertise(f"/{name}/cmd_vel").publish(twist(*value))

    def observed(self, simulation: World) -> object:
        color = simulation.subscribe("/screen/link/visual/color").latest
        return states(simulation), color and color.message

    @rule(
        robot=st.sampled_from(["robot", "other"]),
        velocity=st.tuples(st.sampled_from([0.0, 0.5, -0.3]), st.sampled_from([0.0, 1.0])),
    )
    def command(self, robot: str, velocity: tuple[float, float]) -> None:
        self.do(robot, velocity)

    @rule(rgba=st.sampled_from([RED, BLUE]))
    def color(self, rgba: Rgba) -> None:
        self.do("paint", rgba)
