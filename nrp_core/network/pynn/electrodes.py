"""PyNN's current sources. A network holds steps, and constant currents, which add to the offset current."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from pyNN import common
from pyNN.parameters import ParameterSpace
from pyNN.standardmodels import StandardCurrentSource, electrodes

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import NS_PER_MS, nanoseconds
from nrp_core.errors import CapabilityError
from nrp_core.network.pynn.arguments import (
    InvalidValueError,
    WrongKindError,
    require_kind,
    require_names,
    require_values,
)
from nrp_core.network.pynn.models import untranslated
from nrp_core.network.pynn.populations import require_existing
from nrp_core.network.pynn.simulator import Simulator

_FOREVER_NS = 10**18  # PyNN's


class CurrentSource(StandardCurrentSource):
    """Base of all current sources: parameters as attributes, under PyNN's names."""

    _simulator: Simulator
    default_parameters: dict[str, Any]

    def __init__(self, **parameters: Any) -> None:
        require_names(type(self).__name__, parameters, self.default_parameters)
        require_values(type(self).__name__, parameters)
        for name, value in parameters.items():
            if np.ndim(value) and not np.ndim(getattr(self.default_parameters[name], "value", 0.0)):
                raise InvalidValueError(
                    f"{type(self).__name__}: {name} is {value!r:.60}; it must be one number"
                )
        values = ParameterSpace(self.default_parameters, self.get_schema(), shape=(1,))
        values.update(**parameters)
        self.set_native_parameters(values)
        self._simulator.state.sources.append(self)

    def set_native_parameters(self, parameters: ParameterSpace) -> None:
        """Set the value of each parameter."""
        parameters.evaluate(simplify=True)
        self._require_possible(parameters.as_dict())
        for name, value in parameters.as_dict().items():
            object.__setattr__(self, name, value)  # PyNN's own __setattr__ would recurse

    def _require_possible(self, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            numbers = np.asarray(getattr(value, "value", value), dtype=float)
            allowed, rule = _allowed(name, numbers)
            if not allowed.all():
                raise InvalidValueError(f"{type(self).__name__}: {name} is {numbers}; it must be {rule}")
        start, stop = (values.get(name, self.__dict__.get(name)) for name in ("start", "stop"))
        if start is not None and stop is not None and nanoseconds(stop) < nanoseconds(start):
            raise InvalidValueError(f"{type(self).__name__}: stop is {stop:g} ms, before start, {start:g} ms")

    def get_native_parameters(self) -> ParameterSpace:
        """Return the values of all parameters."""
        values = {name: getattr(self, name) for name in self.default_parameters}
        return ParameterSpace(values, self.get_schema(), shape=(1,))

    def inject_into(self, cells: Iterable[Any]) -> None:
        """Inject the current into cells: a population, view, assembly or list of cells."""
        name = type(self).__name__
        targets = list(cells) if isinstance(cells, Iterable) else [cells]
        for cell in targets:
            if isinstance(cell, common.BasePopulation):
                raise WrongKindError(
                    f"{name}: '{cell.label}' is in a list: inject into it alone, or into a sum"
                )
            require_kind(
                name, "target", cell, common.IDMixin, "a population, view, assembly or list of cells"
            )
            if not cell.celltype.injectable:
                raise WrongKindError(
                    f"{name}: cannot inject current into '{cell.parent.label}', which only emits or "
                    "repeats spikes"
                )
        for population in {cell.parent for cell in targets}:
            require_existing(population.label, population, self._simulator.state)
        self._simulator.state.inject(self, np.array(targets, dtype=np.int64))

    def record(self) -> None:
        """Do nothing: the current is recorded in any case."""

    def _get_data(self) -> tuple[FloatArray, FloatArray]:
        times_ms, amplitudes_na = self._simulator.state.current_data(self)
        return times_ms, amplitudes_na

    def steps(self) -> tuple[FloatArray, FloatArray]:
        """Return the times at which the current changes, ms, and the currents from then on, nA.

        Raises:
            CapabilityError: the current does not change in steps.
        """
        raise CapabilityError(
            f"{type(self).__name__} cannot be part of a network; the nearest that can is a "
            "StepCurrentSource; for other currents, use a device in a transfer function"
        )


class DCSource(CurrentSource, electrodes.DCSource):
    """A constant current of ``amplitude`` nA."""

    translations = untranslated(electrodes.DCSource.default_parameters)

    def steps(self) -> tuple[FloatArray, FloatArray]:
        times_ns = np.maximum(nanoseconds([self.start, self.stop]), 0)
        if times_ns[0] == times_ns[1]:
            return np.zeros(1), np.zeros(1)
        kept = times_ns < _FOREVER_NS
        return times_ns[kept] / NS_PER_MS, np.array([float(self.amplitude), 0.0])[kept]


class ACSource(CurrentSource, electrodes.ACSource):
    """A sinusoidal current."""

    translations = untranslated(electrodes.ACSource.default_parameters)


class StepCurrentSource(CurrentSource, electrodes.StepCurrentSource):
    """A current that changes in steps, at ``times``, or at the points of a grid that are nearest to them."""

    translations = untranslated(electrodes.StepCurrentSource.default_parameters)

    def set_native_parameters(self, parameters: ParameterSpace) -> None:
        super().set_native_parameters(parameters)
        times, amplitudes = (np.asarray(getattr(values, "value", values), dtype=float)
                             for values in (self.times, self.amplitudes))  # fmt: skip
        if len(times) != len(amplitudes):
            raise InvalidValueError(
                f"StepCurrentSource needs as many times as amplitudes, not {len(times)} and {len(amplitudes)}"
            )
        if (np.diff(nanoseconds(times), prepend=-1) <= 0).any():
            raise InvalidValueError(f"StepCurrentSource: times ascend from 0 ms or later, not {times}")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "amplitudes", amplitudes)

    def steps(self) -> tuple[FloatArray, FloatArray]:
        return self.times, self.amplitudes


class NoisyCurrentSource(CurrentSource, electrodes.NoisyCurrentSource):
    """A current of Gaussian noise."""

    translations = untranslated(electrodes.NoisyCurrentSource.default_parameters)


def _allowed(name: str, values: FloatArray) -> tuple[Any, str]:
    """Return which values of a parameter are valid, and a description of the valid values."""
    if name == "stop":
        return values >= 0, "0 ms or more"
    if name == "dt":
        return (values > 0) & np.isfinite(values), "more than 0 ms, and finite"
    if name == "stdev":
        return (values >= 0) & np.isfinite(values), "0 or more, and finite"
    return np.isfinite(values), "finite"
