"""Options of the ``gymnasium`` backend."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

from pydantic import Field

from nrp_core.clock import NS_PER_MS
from nrp_core.quantities import DurationNs
from nrp_core.world import WorldOptions

_USUAL_STEP_NS = 20 * NS_PER_MS


class AtEnd(StrEnum):
    """What follows the end of an episode."""

    RESET = "reset"
    """The next step begins the next episode."""
    HOLD = "hold"
    """The environment stays as it is until the world is reset."""


class GymnasiumOptions(WorldOptions):
    """Options of the ``gymnasium`` backend."""

    env: Annotated[
        str,
        Field(
            min_length=1,
            description="id of the environment, or MODULE:ID to import a module that registers it",
        ),
    ]
    timestep: Annotated[
        DurationNs, Field(gt=0, description="simulated time of one step of the environment")
    ] = _USUAL_STEP_NS
    arguments: Annotated[
        dict[str, Any], Field(default_factory=dict, description="more arguments of gymnasium.make")
    ]
    first_action: Annotated[
        float | list[float] | None,
        Field(description="the action before the first message; by default 0, or the nearest valid value"),
    ] = None
    at_end: Annotated[AtEnd, Field(description="after an episode: reset or hold")] = AtEnd.RESET
    image: Annotated[bool, Field(description="whether /env/image shows the environment")] = False
