"""Device groups: one device for each of several selections, used as one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, overload

import numpy as np

from nrp_core.dsl.devices.devices import Device
from nrp_core.dsl.parameters.adapter import Adapter


class DeviceGroup(Adapter):
    """Devices of one kind that are used together.

    Reading an attribute gives the list of all values. Assigning one number sets all devices; assigning a
    sequence sets each to its own value: ``red.rate = 2000.0 * colors.left_red``.

    Args:
        devices: the devices in the order of the selector; at least one.
    """

    __slots__ = ("_devices",)

    def __init__(self, devices: Sequence[Device]) -> None:
        self._devices = list(devices)

    def __len__(self) -> int:
        return len(self._devices)

    def __iter__(self) -> Iterator[Device]:
        return iter(self._devices)

    @overload
    def __getitem__(self, index: int) -> Device: ...

    @overload
    def __getitem__(self, index: Any) -> DeviceGroup: ...

    def __getitem__(self, index: Any) -> Device | DeviceGroup:
        if isinstance(index, slice):
            return DeviceGroup(self._devices[index])
        if isinstance(index, (int, np.integer)):
            return self._devices[index]
        chosen = np.arange(len(self))[np.asarray(index)]
        return DeviceGroup([self._devices[i] for i in np.atleast_1d(chosen)])

    @property
    def active(self) -> bool:
        """Whether all devices are active."""
        return all(device.active for device in self._devices)

    @active.setter
    def active(self, active: bool) -> None:
        for device in self._devices:
            device.active = active

    def __getattr__(self, name: str) -> list[Any]:
        if name.startswith("_"):
            raise AttributeError(name)
        return [getattr(device, name) for device in self._devices]

    def __setattr__(self, name: str, value: Any) -> None:
        if name in ("_devices", "active"):
            object.__setattr__(self, name, value)
            return
        values = [value] * len(self) if np.ndim(value) == 0 else value
        if len(values) != len(self):
            raise ValueError(f"{self!r}: {len(values)} values for '{name}' of {len(self)} devices")
        for device, one in zip(self._devices, values, strict=True):
            setattr(device, name, one)

    def __repr__(self) -> str:
        return f"<DeviceGroup of {len(self)} devices>"

    def refresh(self, now_ns: int) -> None:
        for device in self._devices:
            device.refresh(now_ns)

    def has_news(self) -> bool | None:
        of_each = [device.has_news() for device in self._devices]
        return None if None in of_each else any(of_each)

    def reset(self) -> None:
        for device in self._devices:
            device.reset()

    def save(self) -> Any:
        return [device.save() for device in self._devices]

    def restore(self, saved: Any) -> None:
        for device, one in zip(self._devices, saved, strict=False):
            device.restore(one)

    def set_active(self, active: bool) -> None:
        self.active = active

    def release(self) -> None:
        for device in self._devices:
            device.release()

    def shown(self) -> str:
        return ", ".join(device.shown() for device in self._devices[:8])
