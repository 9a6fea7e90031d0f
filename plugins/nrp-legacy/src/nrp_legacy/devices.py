"""Devices with the spellings and, where NEST is used directly, the units of the platform: pA, nS and pF."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Any
from weakref import WeakSet

import numpy as np

from nrp_core import dsl
from nrp_core.dsl.devices.devices import (
    CurrentGenerator,
    Device,
    NoiseCurrentGenerator,
    SettableAttribute,
    SineCurrentGenerator,
    SpikeGenerator,
)
from nrp_core.dsl.devices.kinds import DeviceKind
from nrp_core.findings import Code
from nrp_legacy.nest.models import recovering
from nrp_legacy.notes import Notes
from nrp_legacy.sending import sending

_KILO = 1e-3
_LARGEST = sys.float_info.max
_SMALL = frozenset({"amplitude", "offset", "mean", "stdev", "weight", "cm", "i_offset"})
"""Settings in nA, uS or nF, which NEST has in pA, nS or pF."""


class _Forgiving(SettableAttribute):
    """An attribute with another name or unit; invalid values become the nearest valid value.

    Args:
        name: name of the port's attribute.
        scale: factor from the user's unit to that of the port.
        lowest: the lowest valid value.
    """

    def __init__(self, name: str, scale: float = 1.0, lowest: float = -inf) -> None:
        super().__init__(f"{name}, as on the platform.")
        self._port_name, self._scale, self._lowest = name, scale, lowest
        self._told: WeakSet[Any] = WeakSet()

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = self._port_name

    def __get__(self, device: Device | None, owner: type) -> Any:
        value = super().__get__(device, owner)
        return value if device is None else value / self._scale

    def __set__(self, device: Device, value: Any) -> None:
        if isinstance(value, (int, float)) and max(self._lowest, -_LARGEST) <= value <= _LARGEST:
            super().__set__(device, value * self._scale)
            return
        given = np.asarray(value, dtype=float) * self._scale
        taken = np.maximum(np.where(np.isfinite(given), given, 0.0), self._lowest)
        if (taken != given).any() and device.port not in self._told:
            self._told.add(device.port)
            message = f"{device.parameter}: {self._port_name} cannot be {value}: set to {taken}"
            type(device).notes(Code.NRP225, message, subject=device.parameter)  # type: ignore[attr-defined]
        super().__set__(device, taken.item() if taken.size == 1 else taken)


class Spikes(SpikeGenerator):
    """Spikes at a rate."""

    __slots__ = ()
    rate = _Forgiving("rate", lowest=0.0)


class Current(CurrentGenerator):
    """A constant current."""

    __slots__ = ()
    amplitude = _Forgiving("amplitude")


class Sine(SineCurrentGenerator):
    """A sinusoidal current."""

    __slots__ = ()
    amplitude = _Forgiving("amplitude")
    offset = _Forgiving("offset")


class Noise(NoiseCurrentGenerator):
    """A noisy current whose standard deviation has both names."""

    __slots__ = ()
    mean = _Forgiving("mean")
    stdev = std = _Forgiving("stdev", lowest=0.0)


class NestCurrent(CurrentGenerator):
    """A constant current in pA."""

    __slots__ = ()
    amplitude = _Forgiving("amplitude", _KILO)


class NestSine(SineCurrentGenerator):
    """A sinusoidal current in pA."""

    __slots__ = ()
    amplitude = _Forgiving("amplitude", _KILO)
    offset = _Forgiving("offset", _KILO)


class NestNoise(NoiseCurrentGenerator):
    """A noisy current in pA."""

    __slots__ = ()
    mean = _Forgiving("mean", _KILO)
    stdev = std = _Forgiving("stdev", _KILO, lowest=0.0)


def device_kinds(notes: Notes, *, nest_units: bool) -> dict[str, DeviceKind]:
    """Return the lenient kinds of devices, by name.

    Args:
        notes: receives a note about each value that no device can have.
        nest_units: whether currents are in pA.
    """
    currents = (NestCurrent, NestSine, NestNoise) if nest_units else (Current, Sine, Noise)
    kinds = {"dc_source": currents[0], "ac_source": currents[1], "nc_source": currents[2],
             "poisson": Spikes, "fixed_frequency": Spikes}  # fmt: skip
    noting = {"__slots__": (), "notes": staticmethod(notes)}
    forgiving = {
        name: replace(getattr(dsl, name), device=type(device.__name__, (device,), noting))
        for name, device in kinds.items()
    }
    integrators = (dsl.leaky_integrator_alpha, dsl.leaky_integrator_exp)
    return {**forgiving, **{kind.name: sending(kind) for kind in integrators}}


def recovering_at_once(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings in which synapses may have a time constant of recovery of 0, as on the platform."""
    law = settings.get("synapse_type")
    if not isinstance(law, Mapping) or not isinstance(law.get("tau_rec"), (int, float)):
        return dict(settings)
    return {**settings, "synapse_type": {**law, "tau_rec": recovering(law["tau_rec"])}}


def in_our_units(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings in the units of NEST in ours."""
    return {name: _scaled(value) if name in _SMALL else value for name, value in settings.items()}


def _scaled(value: Any) -> Any:
    return [_scaled(one) for one in value] if isinstance(value, (list, tuple)) else value * _KILO
