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


def _no_bytes() -> npt.NDArray[np.uint8]:
    return np.empty(0, np.uint8)


@message("nrp_msgs/msg/Spikes")
@dataclass(slots=True)
class Spikes:
    """Spikes of one population, ascending in time.

    ``ids`` count the neurons of the population from 0; ``times_ms`` are exact times since reset, of the
    same length.
    """

    header: Header = field(default_factory=Header)
    population: str = ""
    ids: npt.NDArray[np.uint32] = field(default_factory=_no_ids)
    times_ms: npt.NDArray[np.float64] = field(default_factory=_no_times)


@message("nrp_msgs/msg/StepHash")
@dataclass(slots=True)
class StepHash:
    """What a step of the closed loop came to, as hashes of the messages that were recorded of it.

    ``brain`` and ``world`` are states (of the brain, the membrane voltages too now and then, which are not
    recorded), ``inputs`` what transfer functions could read, ``outputs`` what they and others wrote: XXH3,
    64 bits. ``chain`` is the BLAKE2b, 128 bits, of the chain one step before and these four. All are
    hexadecimal.
    """

    header: Header = field(default_factory=Header)
    step: int = 0
    brain: str = ""
    world: str = ""
    inputs: str = ""
    outputs: str = ""
    chain: str = ""


@message("nrp_msgs/msg/Snapshot")
@dataclass(slots=True)
class Snapshot:
    """The complete state of a run after a step, for the platform that took it: a Python pickle."""

    header: Header = field(default_factory=Header)
    step: int = 0
    data: npt.NDArray[np.uint8] = field(default_factory=_no_bytes)


@message("nrp_msgs/msg/Called")
@dataclass(slots=True)
class Called:
    """What was done to a run between two steps from outside of it, for the platform that replays it.

    ``name`` is that of a method, ``data`` its arguments: a Python pickle.
    """

    header: Header = field(default_factory=Header)
    name: str = ""
    data: npt.NDArray[np.uint8] = field(default_factory=_no_bytes)


@message("nrp_msgs/msg/Published")
@dataclass(slots=True)
class Published:
    """A message that came from outside of the run, by ``nrp publish``; ``data`` is its CDR."""

    header: Header = field(default_factory=Header)
    topic: str = ""
    type: str = ""
    data: npt.NDArray[np.uint8] = field(default_factory=_no_bytes)
