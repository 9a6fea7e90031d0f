"""Reset one part of a run while its time goes on."""

from __future__ import annotations

from collections.abc import Container
from typing import Final

from nrp_core.brain.interface import Brain
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.world.world import World

PARTS: Final = ("brain", "robot", "world")
"""The parts of a run that can be reset alone."""


def check_part(part: str) -> None:
    """Raise an ``ExperimentError`` for a part that does not exist."""
    if part not in PARTS:
        one_of = f"{', '.join(PARTS)}{did_you_mean(part, PARTS)}"
        raise ExperimentError(f"'{part}' cannot be reset alone, only one of {one_of}")


def reset_part(part: str, brain: Brain, world: World, robots: Container[str]) -> None:
    """Return one part to its state at the start.

    Args:
        part: ``brain``, ``robot`` (the robots, at rest in their initial poses) or ``world`` (all other
            models, in their initial colours too).
        brain: the open brain.
        world: the open world.
        robots: names of the models that are robots.
    """
    if part == "brain":
        brain.reset("state")
        return
    models = [each.name for each in world.scene.models if (each.name in robots) is (part == "robot")]
    world.reset("poses", models)
    if part == "world":
        world.reset("colors", models)
