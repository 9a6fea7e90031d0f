"""Totals of a run: spikes of each neuron, and a digest of the robots' trajectories."""

from __future__ import annotations

import hashlib
import re
import struct
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.devices.sinks import SinkPort, SinkSpec
from nrp_core.brain.network.data import Network
from nrp_core.brain.spikes import Spikes
from nrp_core.world.rigid.pose import Pose

_AUTOMATIC = re.compile(r"population\d+")
"""Automatic names of populations without a label in their script."""


@dataclass(frozen=True, slots=True)
class SpikeCounter(SinkSpec):
    """Counts the spikes of each neuron."""

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> SpikeCounterPort:
        return SpikeCounterPort(neurons, n_neurons, name)


class SpikeCounterPort(SinkPort):
    """A connected spike counter."""

    def __init__(self, neurons: IntArray, n_neurons: int, name: str) -> None:
        super().__init__(neurons, n_neurons, name)
        self._counts = np.zeros(n_neurons, np.int64)

    def of(self, network: Network) -> dict[str, int]:
        """Return the spikes of every view and population by its name.

        A population with an automatic name is left out if a view has the same neurons.
        """
        named = {label: network.neurons(label) for label in network.views}
        viewed = {neurons.tobytes() for neurons in named.values()}
        for label in network.populations:
            neurons = network.neurons(label)
            if label not in named and not (_AUTOMATIC.fullmatch(label) and neurons.tobytes() in viewed):
                named[label] = neurons
        return {label: int(self._counts[neurons].sum()) for label, neurons in named.items()}

    def _absorb(self, spikes: Spikes, until_ms: float) -> None:
        if len(spikes):
            np.add.at(self._counts, spikes.neurons, 1)

    def reset(self) -> None:
        self._counts[:] = 0

    def save(self) -> object:
        return self.active, self._counts.copy()

    def restore(self, saved: Any) -> None:
        self.active, counts = saved
        self._counts[:] = counts


class TrajectoryDigest:
    """A hash of poses, bit for bit; equal digests, equal trajectories.

    The digest of each step is made from the previous one, so the state is a few bytes.

    Attributes:
        state: the digest so far.
    """

    def __init__(self) -> None:
        self.state = b""

    def add(self, poses: Iterable[Pose]) -> None:
        """Add the poses of the robots after one more step."""
        data = b"".join(struct.pack("<7d", *pose.position, *pose.orientation) for pose in poses)
        self.state = hashlib.blake2b(self.state + data, digest_size=16).digest()

    def hexdigest(self) -> str:
        """Return the digest so far."""
        return self.state.hex()
