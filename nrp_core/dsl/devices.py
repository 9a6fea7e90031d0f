"""Devices as transfer functions see them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from math import inf
from operator import attrgetter
from typing import Any, ClassVar, overload

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sinks import SinkPort
from nrp_core.brain.devices.sources import SourcePort
from nrp_core.clock import milliseconds
from nrp_core.dsl.parameters import Adapter
from nrp_core.dsl.selection import Selection
from nrp_core.errors import Hint, NeuronSelectionError, did_you_mean, hint_if_close

Port = SourcePort | SinkPort


class ReadOnlyAttribute:
    """An attribute that shows the port's attribute of the same name."""

    def __init__(self, doc: str) -> None:
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, device: Device | None, owner: type) -> Any:
        return self if device is None else getattr(device.port, self.name)

    def __set__(self, device: Device, value: Any) -> None:
        raise AttributeError(f"{device.parameter}.{self.name} is read-only")


class FilteredAttribute(ReadOnlyAttribute):
    """The present output of a filter of spikes; that of many copies is computed at once."""

    def of_copies(self, devices: Sequence[Device]) -> FloatArray:
        """Return the value of each device."""
        from nrp_core.brain.devices import membrane_kernel  # imported here since it loads a compiler

        values = np.empty(len(devices))
        membrane_kernel.voltages_mv(np.array([*map(_place, devices)], np.int64), values)
        values.flags.writeable = False
        return values


_place = attrgetter("port.place")


class SettableAttribute(ReadOnlyAttribute):
    """An attribute that also sets the port's attribute of the same name."""

    def __set__(self, device: Device, value: Any) -> None:
        try:
            setattr(device.port, self.name, value)
        except (ValueError, TypeError) as error:
            raise ValueError(f"{device.parameter}: {error}") from None


def attribute_hint(name: str, valid: Iterable[str]) -> Hint:
    """Return a hint: the attribute that was probably intended, or all valid ones."""
    return did_you_mean(name, valid, cutoff=0.75)


class Device(Adapter):
    """A device that is bound to a parameter.

    Args:
        parameter: the parameter that it is bound to, for messages.
        port: the device in the brain.
        selection: its neurons.
        release: releases the port.
    """

    __slots__ = ("_release", "parameter", "port", "selection")

    options: ClassVar[tuple[str, ...]] = ()
    """Keyword arguments of a mapping for this class, not for the port."""

    def __init__(self, parameter: str, port: Port, selection: Selection, release: Callable[[], None]) -> None:
        self.parameter = parameter
        self.port: Any = port
        self.selection = selection
        self._release = release

    @classmethod
    def attributes(cls) -> list[str]:
        """Return the names of the attributes that a function can read or set."""
        return [name for name in dir(cls) if isinstance(getattr(cls, name), (ReadOnlyAttribute, property))]

    @property
    def active(self) -> bool:
        """Whether the device is active; an inactive device keeps its settings."""
        return bool(self.port.active)

    @active.setter
    def active(self, active: bool) -> None:
        self.port.active = bool(active)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(self._unknown(name), name=name, obj=self)

    def __setattr__(self, name: str, value: Any) -> None:
        if not hasattr(type(self), name):
            raise AttributeError(self._unknown(name), name=name, obj=self)
        object.__setattr__(self, name, value)

    def _unknown(self, name: str) -> str:
        own = set(dir(type(self))) - set(dir(Device))  # with methods, which are not attributes to read or set
        hint = hint_if_close(name, own) or attribute_hint(name, self.attributes())
        return f"the device '{self.parameter}' has no attribute '{name}'{hint}"

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.parameter} on {self.selection.size} of {self.selection.label}>"

    def set_active(self, active: bool) -> None:
        self.active = active

    def release(self) -> None:
        self._release()


class SpikeGenerator(Device):
    """A Poisson generator or a source of equidistant spikes."""

    __slots__ = ()
    rate = SettableAttribute("Spikes per second and neuron: one number, or one for each neuron.")


class CurrentGenerator(Device):
    """A constant current."""

    __slots__ = ()
    amplitude = SettableAttribute("Current into each neuron, nA: one number, or one for each neuron.")


class SineCurrentGenerator(CurrentGenerator):
    """A sinusoidal current."""

    __slots__ = ()
    offset = SettableAttribute("Mean current into each neuron, nA.")
    frequency = SettableAttribute("Frequency, Hz.")
    phase = SettableAttribute("Phase at the start, degrees.")


class NoiseCurrentGenerator(Device):
    """A noisy current."""

    __slots__ = ()
    mean = SettableAttribute("Mean current into each neuron, nA: one number, or one for each neuron.")
    stdev = SettableAttribute("Standard deviation of the current, nA.")


class LeakyIntegratorDevice(Device):
    """A leaky integrator of the spikes of all its neurons."""

    __slots__ = ()
    voltage = FilteredAttribute("Membrane voltage now, mV.")

    def value_text(self) -> str:
        return f"voltage = {self.voltage:g}"


class PopulationRateDevice(Device):
    """The smoothed firing rate of all its neurons together."""

    __slots__ = ()
    rate = FilteredAttribute("Sum of the firing rates now, Hz.")

    def value_text(self) -> str:
        return f"rate = {self.rate:g}"


class SpikeInjectorDevice(Device):
    """A source of single spikes."""

    __slots__ = ()

    def inject_spikes(
        self, neuron_ids: npt.ArrayLike | None = None, times_ms: npt.ArrayLike | None = None
    ) -> None:
        """Send a spike to neurons, given by their indices in the device; by default to all of them, now."""
        try:
            self.port.inject_spikes(neuron_ids, times_ms)
        except (ValueError, TypeError, NeuronSelectionError) as error:
            raise ValueError(f"{self.parameter}: {error}") from None


class RecorderDevice(Device):
    """The data recorded since the function last ran, at most those of the last ``keep_ms``."""

    __slots__ = ("_seen", "_until_ms")

    _seen: Any
    _until_ms: float

    def __init__(self, parameter: str, port: Port, selection: Selection, release: Callable[[], None]) -> None:
        super().__init__(parameter, port, selection, release)
        self.reset()

    def refresh(self, now_ns: int) -> None:
        since_ms, self._until_ms = self._until_ms, milliseconds(now_ns)
        self._seen = self._recorded(since_ms, self._until_ms)

    def reset(self) -> None:
        self._until_ms = -inf
        self._seen = self._recorded(inf, inf)

    def save(self) -> Any:
        return self._until_ms, self._seen

    def restore(self, saved: Any) -> None:
        self._until_ms, self._seen = saved

    def _recorded(self, since_ms: float, until_ms: float) -> Any:
        """Return the data recorded with ``since_ms < t <= until_ms``."""
        raise NotImplementedError


class StateRecorderDevice(RecorderDevice):
    """Voltages or conductances of its neurons."""

    __slots__ = ()

    def _recorded(self, since_ms: float, until_ms: float) -> Any:
        return self.port.samples(since_ms, until_ms)

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """Times of the samples, ms, shape ``(n,)``."""
        times: npt.NDArray[np.float64] = self._seen[0]
        return times

    @property
    def values(self) -> npt.NDArray[np.float64]:
        """Samples, mV or uS, shape ``(n, neurons)``."""
        values: npt.NDArray[np.float64] = self._seen[1]
        return values

    def value_text(self) -> str:
        return f"{len(self.times)} samples"


class SpikeRecorderDevice(RecorderDevice):
    """Spikes of its neurons."""

    __slots__ = ("_use_ids",)

    options: ClassVar[tuple[str, ...]] = ("use_ids",)

    def __init__(
        self,
        parameter: str,
        port: Port,
        selection: Selection,
        release: Callable[[], None],
        *,
        use_ids: bool = True,
    ) -> None:
        super().__init__(parameter, port, selection, release)
        self._use_ids = use_ids

    def _recorded(self, since_ms: float, until_ms: float) -> Any:
        return self.port.spikes(since_ms, until_ms)

    def has_news(self) -> bool:
        return len(self._recorded(self._until_ms, inf)) > 0

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """Neuron and time in ms of each spike, ascending in time, shape ``(n, 2)``.

        Neurons are global ids, or with ``use_ids=False`` indices in the selection.
        """
        ids = self._seen.neurons
        if not self._use_ids:
            order = np.argsort(self.selection.ids, kind="stable")
            ids = order[np.searchsorted(self.selection.ids, ids, sorter=order)]
        return np.stack([ids, self._seen.times_ms], axis=1)

    @property
    def spiked(self) -> bool:
        """Whether any neuron spiked."""
        return len(self._seen) > 0

    @property
    def neurons(self) -> IntArray:
        """Global ids of the recorded neurons."""
        return self.selection.ids

    @property
    def neurons_count(self) -> int:
        """Number of recorded neurons."""
        return self.selection.size

    @property
    def population_name(self) -> str:
        """Name of the population of the neurons."""
        return self.selection.label

    def value_text(self) -> str:
        return f"times = {len(self._seen)} rows of neuron and ms"


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

    def runs_users_code(self) -> bool:
        return any(device.runs_users_code() for device in self._devices)

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

    def value_text(self) -> str:
        return ", ".join(device.value_text() for device in self._devices[:8])
