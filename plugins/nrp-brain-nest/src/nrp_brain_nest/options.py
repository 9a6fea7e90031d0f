"""Options of the ``nest`` backend."""

from __future__ import annotations

from typing import Annotated

from nrp_core.brain import RemoteOptions
from nrp_core.clock import NS_PER_MS
from nrp_core.quantities import DurationNs
from pydantic import AfterValidator, Field

_NS_PER_TIC = 1000


def _whole_tics(t_ns: int) -> int:
    if t_ns % _NS_PER_TIC or t_ns > NS_PER_MS:
        raise ValueError(f"NEST's grid is a whole number of microseconds up to 1 ms, not {t_ns} ns")
    return t_ns


class NestOptions(RemoteOptions):
    """Options of the ``nest`` backend."""

    resolution: Annotated[DurationNs, AfterValidator(_whole_tics)] = Field(
        default=100_000, description="the time grid of spikes and membrane updates"
    )
    threads: int = Field(default=1, ge=1, description="number of threads for the neurons")
