"""The base of all sources: the specification, the port that it opens, and settings for each neuron."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any, ClassVar, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.network.data import RECEPTORS, Network
from nrp_core.seeds import Seeds

Value = float | Sequence[float] | FloatArray
"""A value of a setting: one number for all neurons, or one for each."""

NO_EVENTS: Final = SynapticEvents(np.empty(0, np.int64), np.empty(0), np.empty(0))


@dataclass(frozen=True, slots=True)
class SourceSpec(ABC):
    """The specification of a source; :meth:`open` connects it to neurons."""

    @abstractmethod
    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> SourcePort:
        """Return a source connected to ``neurons`` (global ids)."""


class SourcePort(ABC):
    """A connected source. ``active = False`` silences it and keeps its settings.

    Attributes:
        quantity: the name of its main setting, for recorders; None if it has none.
        unit: the unit of that setting.
    """

    quantity: ClassVar[str | None] = None
    unit: ClassVar[str] = ""

    def __init__(self, neurons: IntArray, name: str) -> None:
        self.neurons = neurons
        self.name = name
        self.active = True

    def start(self, now_ms: float, network: Network) -> None:
        """Connect to a network."""

    def events(self, since_ms: float, until_ms: float) -> SynapticEvents:
        """Return the events emitted with ``since_ms < t <= until_ms``, with their arrival times."""
        return NO_EVENTS

    @abstractmethod
    def reset(self, seeds: Seeds) -> None:
        """Restart at time 0 with new random streams and the specification's settings."""

    @abstractmethod
    def save(self) -> object:
        """Return all state that changes while running."""

    @abstractmethod
    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""


def check_synapse(weight: float, delay: float, receptor_type: str) -> None:
    """Check the weight, delay and receptor of a spike source.

    Raises:
        ValueError: a value is invalid.
    """
    if not isfinite(weight):
        raise ValueError(f"weight must be finite, not {weight}")
    if not (isfinite(delay) and delay >= 0):
        raise ValueError(f"delay must be 0 ms or more, not {delay}")
    if receptor_type not in RECEPTORS:
        raise ValueError(f"receptor_type is {' or '.join(RECEPTORS)}, not '{receptor_type}'")


def check_sign(weight: float, receptor_type: str, neurons: IntArray, network: Network) -> None:
    """Check that the weight of a spike source does not act against its receptor.

    A conductance is never negative; a positive current into the inhibitory receptor would excite.

    Raises:
        ValueError: it does, for one of the neurons.
    """
    if weight >= 0 and (weight == 0 or receptor_type == "excitatory"):
        return
    for label, population in network.populations.items():
        inside = neurons - network.offsets[label]
        if population.is_source or not ((inside >= 0) & (inside < population.size)).any():
            continue
        if population.is_conductance_based and weight < 0:
            raise ValueError(
                f"weight is {weight:g} uS, and the conductances of '{label}' are never negative; "
                "a source that inhibits has receptor_type='inhibitory'"
            )
        if not population.is_conductance_based and weight > 0:
            raise ValueError(
                f"weight is {weight:g}; it must be 0 or less on the inhibitory receptor of '{label}', whose "
                "cells are current-based: a positive weight would excite them"
            )


class Setting:
    """A value for each neuron, usually the same for all.

    Args:
        what: the setting's name, for messages.
        size: number of neurons.
        least, most: the smallest and the largest value allowed.

    Attributes:
        common: the value of all neurons, or None if they differ.
    """

    def __init__(self, what: str, size: int, *, least: float = -inf, most: float = inf) -> None:
        self._what, self._size, self._least, self._most = what, size, least, most
        self.common: float | None = 0.0
        self._each: FloatArray | None = None

    def set(self, value: Value) -> None:
        """Set one number for all neurons, or one for each.

        Raises:
            ValueError: a value is not finite, too small or too large, or the number of values is wrong.
        """
        if isinstance(
            value, (int, float)
        ):  # fast path for transfer functions, which set a scalar in every step
            self._require(isfinite(value) and self._least <= value <= self._most, value)
            self.common, self._each = float(value), None
            return
        array = np.asarray(value)
        if array.dtype.kind not in "fiub":
            raise ValueError(f"{self._what} takes a number, or one for each neuron, not {value!r}")
        array = array.astype(float)
        if array.ndim and array.shape != (self._size,):
            raise ValueError(f"{self._what} takes one value or {self._size}, not {array.size}")
        fits = np.isfinite(array) & (array >= self._least) & (array <= self._most)
        self._require(bool(fits.all()), value)
        same = array.ndim == 0 or array.size == 0 or bool((array == array.flat[0]).all())
        self.common = (float(array.flat[0]) if array.size else 0.0) if same else None
        self._each = None if same else array.copy()

    @property
    def value(self) -> float | FloatArray:
        """One number if all neurons have the same."""
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
