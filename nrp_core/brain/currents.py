"""Currents into neurons from outside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nrp_core.brain.network import FloatArray, IntArray
from nrp_core.brain.ports import Setting, SourcePort, SourceSpec, Value
from nrp_core.seeds import Seeds


@dataclass(frozen=True, slots=True)
class DCSource(SourceSpec):
    """A constant current into each neuron.

    Args:
        amplitude: nA: one number, or one for each neuron.
    """

    amplitude: Value = 0.0

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> DCPort:
        return DCPort(self, neurons, name)


class DCPort(SourcePort):
    """A :class:`DCSource` at work."""

    quantity, unit = "amplitude", "nA"

    def __init__(self, spec: DCSource, neurons: IntArray, name: str) -> None:
        super().__init__(neurons, name)
        self._spec = spec
        self._amplitudes = Setting("amplitude", len(neurons))
        self.amplitude = spec.amplitude

    @property
    def amplitude(self) -> float | FloatArray:
        """Current into each neuron, nA: one number where all have the same."""
        return self._amplitudes.value

    @amplitude.setter
    def amplitude(self, value: Value) -> None:
        self._amplitudes.set(value)

    def current_na(self, now_ms: float) -> FloatArray | None:
        return self._amplitudes.each if self.active else np.zeros(len(self.neurons))

    def reset(self, seeds: Seeds) -> None:
        self.amplitude = self._spec.amplitude

    def save(self) -> object:
        return self.amplitude, self.active

    def restore(self, saved: Any) -> None:
        self.amplitude, self.active = saved
