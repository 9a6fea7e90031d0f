"""The platform's own messages, for data without a ROS standard."""

from __future__ import annotations

from dataclasses import field

import numpy as np
import numpy.typing as npt

from nrp_core.messages.base import array_field, message
from nrp_core.messages.std_msgs import Header


@message("nrp_msgs/msg/Spikes")
class Spikes:
    """Spikes of one population in order of time.

    ``ids`` are indices in the population; ``times_ms`` are exact times since reset, of the same length.
    """

    header: Header = field(default_factory=Header)
    population: str = ""
    ids: npt.NDArray[np.uint32] = array_field(np.uint32)
    times_ms: npt.NDArray[np.float64] = array_field()


@message("nrp_msgs/msg/StepHash")
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
class Snapshot:
    """The complete state of a run after a step: a Python pickle, for the version that wrote it."""

    header: Header = field(default_factory=Header)
    step: int = 0
    data: npt.NDArray[np.uint8] = array_field(np.uint8)


@message("nrp_msgs/msg/Called")
class Called:
    """A call from outside the run between two steps, for replays.

    ``name`` is the name of the method, ``data`` a Python pickle of its arguments.
    """

    header: Header = field(default_factory=Header)
    name: str = ""
    data: npt.NDArray[np.uint8] = array_field(np.uint8)


@message("nrp_msgs/msg/Published")
class Published:
    """A message published from outside the run, by ``nrp publish``; ``data`` is its CDR encoding."""

    header: Header = field(default_factory=Header)
    topic: str = ""
    type: str = ""
    data: npt.NDArray[np.uint8] = array_field(np.uint8)


@message("nrp_msgs/msg/MuscleState")
class MuscleState:
    """The state of one muscle.

    ``length`` (m) is that of its path, ``velocity`` (m/s) is positive where it lengthens, and ``force`` (N)
    is its tension, positive where it pulls. ``activation`` is from 0 to 1, ``normalized_length`` that of its
    contractile part in optimal lengths, ``normalized_force`` the tension in peak forces, and
    ``normalized_velocity`` the velocity in optimal lengths per second.
    """

    header: Header = field(default_factory=Header)
    length: float = 0.0
    velocity: float = 0.0
    force: float = 0.0
    activation: float = 0.0
    normalized_length: float = 0.0
    normalized_force: float = 0.0
    normalized_velocity: float = 0.0


@message("nrp_msgs/msg/MuscleStates")
class MuscleStates:
    """The states of several muscles, as in :class:`MuscleState`; all arrays are in the order of ``name``."""

    header: Header = field(default_factory=Header)
    name: list[str] = field(default_factory=list)
    length: npt.NDArray[np.float64] = array_field()
    velocity: npt.NDArray[np.float64] = array_field()
    force: npt.NDArray[np.float64] = array_field()
    activation: npt.NDArray[np.float64] = array_field()
    normalized_length: npt.NDArray[np.float64] = array_field()
    normalized_force: npt.NDArray[np.float64] = array_field()
    normalized_velocity: npt.NDArray[np.float64] = array_field()
