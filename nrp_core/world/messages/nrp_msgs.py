"""The platform's own messages, for data without a ROS standard."""

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
    """Spikes of one population in order of time.

    ``ids`` are indices in the population; ``times_ms`` are exact times since reset, of the same length.
    """

    header: Header = field(default_factory=Header)
    population: str = ""
    ids: npt.NDArray[np.uint32] = field(default_factory=_no_ids)
    times_ms: npt.NDArray[np.float64] = field(default_factory=_no_times)


@message("nrp_msgs/msg/StepHash")
@dataclass(slots=True)
class StepHash:
    """Hashes of the messages recorded in a step of the closed loop.

    ``brain`` and ``world`` are hashes of states (at intervals also of the membrane voltages, which are not
    recorded), ``inputs`` of the data that transfer functions could read, ``outputs`` of the data that they
    and others wrote: XXH3, 64 bits. ``chain`` is the BLAKE2b, 128 bits, of the previous chain and these four.
    All are hexadecimal.
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
    """The complete state of a run after a step: a Python pickle, for the version that wrote it."""

    header: Header = field(default_factory=Header)
    step: int = 0
    data: npt.NDArray[np.uint8] = field(default_factory=_no_bytes)


@message("nrp_msgs/msg/Called")
@dataclass(slots=True)
class Called:
    """A call from outside the run between two steps, for replays.

    ``name`` is the name of the method, ``data`` a Python pickle of its arguments.
    """

    header: Header = field(default_factory=Header)
    name: str = ""
    data: npt.NDArray[np.uint8] = field(default_factory=_no_bytes)


@message("nrp_msgs/msg/Published")
@dataclass(slots=True)
class Published:
    """A message published from outside the run, by ``nrp publish``; ``data`` is its CDR encoding."""

    header: Header = field(default_factory=Header)
    topic: str = ""
    type: str = ""
    data: npt.NDArray[np.uint8] = field(default_factory=_no_bytes)
