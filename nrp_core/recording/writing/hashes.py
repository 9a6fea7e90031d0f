"""A chain of hashes of the steps; equal chains mean equal runs so far."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xxhash

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.interface import Brain
from nrp_core.errors import CapabilityError
from nrp_core.network.voltages import VOLTAGE
from nrp_core.recording.layout import Role
from nrp_core.recording.writing.encoding import Packed
from nrp_core.recording.writing.signals import RecordEntry
from nrp_core.world.world import World

BRAIN, WORLD, INPUTS, OUTPUTS = range(4)
GROUPS = ("brain", "world", "inputs", "outputs")
"""The hashed groups of a step: two states, the data that transfer functions could read, and written data."""

GROUP_OF = {
    Role.SPIKES.value: BRAIN,
    Role.VOLTAGE.value: BRAIN,
    Role.MODELS.value: WORLD,
    Role.SENSOR.value: INPUTS,
    Role.CAMERA.value: INPUTS,
    Role.SINK.value: INPUTS,
    Role.PUBLISHED.value: OUTPUTS,
    Role.SOURCE.value: OUTPUTS,
}
VOLTAGES_EVERY = 25
"""Spikes and values of devices are hashed in every step; membrane voltages only in every
25th, because reading them costs as much as all other recording."""


class Step(NamedTuple):
    """One observed step.

    Args:
        t_ns: its end, ns.
        entries: the messages, in the order of time.
        voltages: the membrane voltages, in the steps in which they are hashed.
    """

    t_ns: int
    entries: Sequence[RecordEntry]
    voltages: FloatArray | None


class Voltages:
    """Reads the membrane voltages of a brain, only in some steps because it is slow."""

    def __init__(self, brain: Brain) -> None:
        self._brain, self._shown = brain, _showing_voltage(brain)

    def at(self, step: int) -> FloatArray | None:
        """Return the voltages, or None in steps in which they are not hashed."""
        if step % VOLTAGES_EVERY or not len(self._shown):
            return None
        return self._brain.read_state(VOLTAGE, self._shown)


class Hasher:
    """Hashes the messages of a step, group by group; for compressed pixels it uses their own hash."""

    def __init__(self) -> None:
        self._topics: dict[str, tuple[int | None, bytes]] = {}

    def hashes(self, step: Step) -> list[str]:
        """Return the hashes of a step, in the order of :data:`GROUPS`."""
        counted: tuple[list[Any], ...] = ([], [], [], [])
        if step.voltages is not None:
            counted[BRAIN].append(step.voltages.data)
        for entry in step.entries:
            group, name = self._topics.get(entry.topic) or self._know(entry)
            if group is not None:
                counted[group].append(name)
                for part in entry.parts:
                    counted[group].append(part.digest if isinstance(part, Packed) else part)
        return [hash_of(one) for one in counted]

    def _know(self, entry: RecordEntry) -> tuple[int | None, bytes]:
        """Return the group of a topic, if it is hashed, and its name as bytes."""
        known = GROUP_OF.get(entry.about["role"]), entry.topic.encode()
        self._topics[entry.topic] = known
        return known


def hash_of(counted: Iterable[Any]) -> str:
    """Return the hash of one group of a step: each topic, and the bytes of its message."""
    return xxhash.xxh3_64_hexdigest(b"".join(counted))


class Chain:
    """The chain of the hashes of all steps.

    Args:
        value: its initial value, hexadecimal.
    """

    def __init__(self, value: str) -> None:
        self.value = value

    @classmethod
    def begin(cls, brain: Brain, world: World) -> Chain:
        """Return a new chain, which depends on the network, the scene and the seed."""
        return cls.of(brain.network.digest, world.scene.digest, brain.seed)

    @classmethod
    def of(cls, network: str, scene: str, seed: int) -> Chain:
        """Return a new chain, given the digests of network and scene."""
        return cls(_hash(f"{network} {scene} {seed}"))

    def add(self, hashes: Sequence[str]) -> str:
        """Add the hashes of a step and return the new value."""
        self.value = _hash(" ".join((self.value, *hashes)))
        return self.value


def _hash(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def _showing_voltage(brain: Brain) -> IntArray:
    """Return the neurons (global ids) whose membrane voltage can be read."""
    shown = [np.empty(0, np.int64)]
    if VOLTAGE in brain.capabilities.state_variables:
        for label, population in brain.network.populations.items():
            ids = brain.network.ids_of(label)
            if population.is_source:
                continue
            try:
                brain.read_state(VOLTAGE, ids)
            except CapabilityError:
                continue
            shown.append(ids)
    return np.concatenate(shown)
