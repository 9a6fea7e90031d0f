"""What all sources have in common: the specification, the port it opens, settings for each neuron."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any, ClassVar, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.network.data import RECEPTORS, Network
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.seeds import Seeds

Value = float | Sequence[float] | FloatArray
"""What a setting takes: one number for all neurons, or one for each."""

NO_EVENTS: Final = SynapticEvents(np.empty(0, np.int64), np.empty(0), np.empty(0))


@dataclass(frozen=True, slots=True)
class SourceSpec(ABC):
    """What a source is; :meth:`open` makes it work on neurons."""

    @abstractmethod
    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> SourcePort:
        """Return the source at work on ``neurons`` (global ids)."""


class SourcePort(ABC):
    """A source at work. ``active = False`` silences it and keeps its settings.

    Attributes:
        quantity: the attribute that sets it, for recorders; None where it has no such.
        unit: of that value.
    """

    quantity: ClassVar[str | None] = None
    unit: ClassVar[str] = ""

    def __init__(self, neurons: IntArray, name: str) -> None:
        self.neurons = neurons
        self.name = name
        self.active = True

    def start(self, now_ms: float, network: Network) -> None:
        """Begin to act on a network."""

    def events(self, since_ms: float, until_ms: float) -> SynapticEvents:
        """Return what was emitted with ``since_ms < t <= until_ms``, by time of arrival."""
        return NO_EVENTS

    @abstractmethod
    def reset(self, seeds: Seeds) -> None:
        """Start anew at time 0 with new streams; settings go back to the specification."""

    @abstractmethod
    def save(self) -> object:
        """Return everything that changes while running."""

    @abstractmethod
    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave."""


def check_synapse(weight: float, delay: float, receptor_type: str) -> None:
    """Check how a spike source is connected.

    Raises:
        ValueError: a value is impossible.
    """
    if not isfinite(weight):
        raise ValueError(f"weight must be finite, not {weight}")
    if not (isfinite(delay) and delay >= 0):
        raise ValueError(f"delay must be 0 ms or more, not {delay}")
    if receptor_type not in RECEPTORS:
        raise ValueError(f"receptor_type is {' or '.join(RECEPTORS)}, not '{receptor_type}'")


class Setting:
    """A value for each neuron, which most of the time is the same for all.

    Args:
        what: its name, for messages.
        size: number of neurons.
        least, most: the smallest and the largest value allowed.

    Attributes:
        common: the value of all neurons, or None where they differ.
    """

    def __init__(self, what: str, size: int, *, least: float = -inf, most: float = inf) -> None:
        self._what, self._size, self._least, self._most = what, size, least, most
        self.common: float | None = 0.0
        self._each: FloatArray | None = None

    def set(self, value: Value) -> None:
        """Take one number, or one for each neuron.

        Raises:
            ValueError: a value is not finite, too small or too large, or the number of values is another.
        """
        if isinstance(value, (int, float)):  # the way of a transfer function, 50 times a second
            self._require(isfinite(value) and self._least <= value <= self._most, value)
            self.common, self._each = float(value), None
            return
        array = np.asarray(value, dtype=float)
        if array.ndim and array.shape != (self._size,):
            raise ValueError(f"{self._what} takes one value or {self._size}, not {array.size}")
        fits = np.isfinite(array) & (array >= self._least) & (array <= self._most)
        self._require(bool(fits.all()), value)
        same = array.ndim == 0 or array.size == 0 or bool((array == array.flat[0]).all())
        self.common = (float(array.flat[0]) if array.size else 0.0) if same else None
        self._each = None if same else array.copy()

    @property
    def value(self) -> float | FloatArray:
        """One number where all neurons have the same."""
        return self.each.copy() if self.common is None else self.common

    @property
    def each(self) -> FloatArray:
        """The value of each neuron."""
        if self._each is None:
            self._each = np.full(self._size, self.common)
        return self._each

    def _require(self, allowed: bool, value: Value) -> None:
        if not allowed:
            limit = "" if self._least == -inf else f" and at least {self._least:g}"
            if bool(np.any(np.asarray(value) > self._most)):
                limit = f" and at most {self._most:g}"
            raise ValueError(f"{self._what} must be finite{limit}, not {value}")
