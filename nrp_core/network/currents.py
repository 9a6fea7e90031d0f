"""Currents that flow into cells at given times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import FOREVER_NS, nanoseconds
from nrp_core.errors import NetworkError
from nrp_core.network.frozen_values import freeze_value, global_ids


@dataclass(frozen=True, slots=True)
class InjectedCurrent:
    """A current into cells, constant between given times and 0 before the first.

    Args:
        neurons: the cells, by their global ids; a repeated cell receives it repeatedly.
        times_ms: ascending times from 0 at which it changes, shape ``(n,)``.
        amplitudes_na: the current into each cell from these times on, nA, shape ``(n,)``.

    Attributes:
        times_ns: the same times in nanoseconds.

    Raises:
        NetworkError: the times do not ascend, or a value is not finite.
    """

    neurons: IntArray
    times_ms: FloatArray
    amplitudes_na: FloatArray
    times_ns: IntArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "neurons", global_ids("an injected current", self.neurons))
        for name in ("times_ms", "amplitudes_na"):
            values = np.array(getattr(self, name), float)
            if values.ndim != 1 or not np.isfinite(values).all():
                raise NetworkError(f"an injected current: its {name} are finite numbers, not {values!r:.60}")
            object.__setattr__(self, name, freeze_value(values))
        if len(self.times_ms) != len(self.amplitudes_na):
            raise NetworkError(
                f"an injected current has {len(self.times_ms)} times and {len(self.amplitudes_na)} amplitudes"
            )
        object.__setattr__(self, "times_ns", freeze_value(nanoseconds(self.times_ms)))
        if (np.diff(self.times_ns, prepend=-1) <= 0).any():
            raise NetworkError(
                f"an injected current: its times are {self.times_ms}; they must ascend from 0 ms or later"
            )

    def current_na(self, now_ns: int) -> float:
        """Return the current from a time on."""
        step = int(np.searchsorted(self.times_ns, now_ns, side="right")) - 1
        return float(self.amplitudes_na[step]) if step >= 0 else 0.0

    def next_change_ns(self, now_ns: int) -> int:
        """Return the first time after ``now_ns`` at which it changes."""
        step = int(np.searchsorted(self.times_ns, now_ns, side="right"))
        return int(self.times_ns[step]) if step < len(self.times_ns) else FOREVER_NS


class Injections:
    """The sum of all currents of a network, which is computed again only when one of them changes.

    Args:
        currents: the currents.
        size: number of neurons of the network.
    """

    def __init__(self, currents: Sequence[InjectedCurrent], size: int) -> None:
        self._currents, self._size = currents, size
        self._since_ns, self._until_ns, self._total = FOREVER_NS, FOREVER_NS, np.zeros(size)

    def __len__(self) -> int:
        return len(self._currents)

    def total_na(self, now_ns: int) -> FloatArray:
        """Return the current into each neuron from a time on."""
        if not self._since_ns <= now_ns < self._until_ns:
            self._total = np.zeros(self._size)
            for current in self._currents:
                np.add.at(self._total, current.neurons, current.current_na(now_ns))
            self._since_ns = now_ns
            self._until_ns = min((one.next_change_ns(now_ns) for one in self._currents), default=FOREVER_NS)
        return self._total

    def next_change_ns(self, now_ns: int) -> int:
        """Return the first time after ``now_ns`` at which one changes."""
        self.total_na(now_ns)
        return self._until_ns


def require_targets(current: InjectedCurrent, populations: Mapping[str, Any]) -> None:
    """Check that a current flows into cells that exist and have a membrane.

    Args:
        current: the current.
        populations: those of its network, by label.

    Raises:
        NetworkError: it does not.
    """
    first = 0
    for label, population in populations.items():
        inside = (current.neurons >= first) & (current.neurons < first + population.size)
        if (population.is_source or population.is_relay) and inside.any():
            verb = "emits" if population.is_source else "repeats"
            raise NetworkError(f"a current is injected into '{label}', which only {verb} spikes")
        first += population.size
    outside = current.neurons[(current.neurons < 0) | (current.neurons >= first)]
    if len(outside):
        raise NetworkError(f"a current is injected into neuron {outside[0]}; the network has {first}")
