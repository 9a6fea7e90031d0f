"""Devices with the spellings and, where NEST is used directly, the units of the platform: pA, nS and pF."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from nrp_core import dsl
from nrp_core.dsl.devices import (
    CurrentGenerator,
    Device,
    NoiseCurrentGenerator,
    Setting,
    SineCurrentGenerator,
)
from nrp_core.dsl.kinds import DeviceKind

_KILO = 1e-3
_SMALL = frozenset({"amplitude", "offset", "mean", "stdev", "weight", "cm", "i_offset"})
"""Settings in nA, uS or nF, which NEST has in pA, nS or pF."""


class _Renamed(Setting):
    """An attribute under another name, in another unit.

    Args:
        name: of the port's attribute.
        scale: from the unit of users to that of the port.
    """

    def __init__(self, name: str, scale: float) -> None:
        super().__init__(f"{name}, in the unit of NEST.")
        self._port_name, self._scale = name, scale

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = self._port_name

    def __get__(self, device: Device | None, owner: type) -> Any:
        value = super().__get__(device, owner)
        return value if device is None else value / self._scale

    def __set__(self, device: Device, value: Any) -> None:
        super().__set__(device, value * self._scale)


class Noise(NoiseCurrentGenerator):
    """A noisy current whose standard deviation has both names."""

    __slots__ = ()
    std = _Renamed("stdev", 1.0)


class NestCurrent(CurrentGenerator):
    """A constant current in pA."""

    __slots__ = ()
    amplitude = _Renamed("amplitude", _KILO)


class NestSine(SineCurrentGenerator):
    """A sinusoidal current in pA."""

    __slots__ = ()
    amplitude = _Renamed("amplitude", _KILO)
    offset = _Renamed("offset", _KILO)


class NestNoise(NoiseCurrentGenerator):
    """A noisy current in pA."""

    __slots__ = ()
    mean = _Renamed("mean", _KILO)
    stdev = _Renamed("stdev", _KILO)
    std = _Renamed("stdev", _KILO)


def device_kinds(*, nest_units: bool) -> dict[str, DeviceKind]:
    """Return the kinds that differ from ours, by name."""
    dc, ac, nc = dsl.dc_source, dsl.ac_source, dsl.nc_source
    if not nest_units:
        return {"nc_source": replace(nc, device=Noise)}
    return {
        "dc_source": replace(dc, device=NestCurrent),
        "ac_source": replace(ac, device=NestSine),
        "nc_source": replace(nc, device=NestNoise),
    }


def in_our_units(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings in the units of NEST in ours."""
    return {name: _scaled(value) if name in _SMALL else value for name, value in settings.items()}


def _scaled(value: Any) -> Any:
    return [_scaled(one) for one in value] if isinstance(value, (list, tuple)) else value * _KILO
