"""Random sequences of calls on a world."""

from __future__ import annotations

from functools import partial
from typing import Any

from hypothesis import strategies as st
from hypothesis.stateful import rule

from nrp_core.conformance.sequences import SequenceMachine, check_sequences
from nrp_core.conformance.world.kit import WorldKit, paint, states, twist
from nrp_core.conformance.world.scenes import BLUE, RED
from nrp_core.conformance.world.state import busy
from nrp_core.world.scene.model import Rgba, Scene
from nrp_core.world.world import World


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

    def seen(self, simulation: World) -> object:
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
