"""The platform's own messages, for what ROS has no standard for."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from nrp_core.world.messages.base import message
from nrp_core.world.messages.std_msgs import Header


def _no_ids() -> npt.NDArray[np.uint32]:
    return np.empty(0, np.uint32)


def _no_times() -> npt.NDArray[np.float64]:
    return np.empty(0)


@message("nrp_msgs/msg/Spikes")
@dataclass(slots=True)
class Spikes:
    """Spikes of one population, ascending in time.

    ``ids`` count the neurons of the population from 0; ``times`` are seconds of simulated time since
    reset, exact, of the same length.
    """

    header: Header = field(default_factory=Header)
    population: str = ""
    ids: npt.NDArray[np.uint32] = field(default_factory=_no_ids)
    times: npt.NDArray[np.float64] = field(default_factory=_no_times)
