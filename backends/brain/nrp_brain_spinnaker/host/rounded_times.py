"""Times of a network that the machine moves to whole steps, and steps that it cannot keep up with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from nrp_brain_spinnaker.options import SpinnakerOptions
from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.data import Network
from nrp_core.findings import Code, Findings

_SHORTEST_STEP_US = 100
"""Below it sPyNNaker warns that a machine does not keep up, unless it is slowed down."""
_ROUNDING = 1e-6


def rounded_times(network: Network, options: SpinnakerOptions) -> Findings:
    """Return warnings about a very short step, and about spikes and refractory periods between two steps."""
    step_ms, warnings = options.step_us / 1000, Findings()
    if options.step_us < _SHORTEST_STEP_US:
        warnings.add(
            Code.NRP217,
            f"a time step of {step_ms:g} ms is below 0.1 ms, the shortest that a machine keeps up with; a "
            "real one needs a time_scale_factor",
        )
    between = list(_spikes(network, step_ms))
    if between:
        warnings.add(
            Code.NRP217, f"spikes between time steps of {step_ms:g} ms come at the next: {_listed(between)}"
        )
    rounded = list(_refractory(network, step_ms / options.substeps))
    if rounded:
        warnings.add(Code.NRP217, f"refractory periods become whole time steps: {_listed(rounded)}")
    return warnings


def _listed(moved: Sequence[tuple[str, float, float]]) -> str:
    names = ", ".join(f"'{label}' ({old_ms:g} -> {new_ms:g} ms)" for label, old_ms, new_ms in moved[:3])
    return names + (f" and {len(moved) - 3} more" if len(moved) > 3 else "")


def _spikes(network: Network, step_ms: float) -> Iterator[tuple[str, float, float]]:
    """Yield the first spike time of each population that is between two steps, ms, before and after."""
    for population in network.populations.values():
        times = [np.asarray(one, float) for one in population.spike_times_ms if len(one)]
        if times:
            yield from _first_between(population.label, np.concatenate(times), step_ms)


def _refractory(network: Network, step_ms: float) -> Iterator[tuple[str, float, float]]:
    """Yield the first refractory period of each population that is not a number of steps, before and after.

    Periods of less than a step, such as PyNN's default, mean none.
    """
    for population in network.populations.values():
        periods = population.parameters.get("tau_refrac", np.empty(0))
        yield from _first_between(population.label, periods[periods > step_ms], step_ms)


def _first_between(label: str, times_ms: FloatArray, step_ms: float) -> Iterator[tuple[str, float, float]]:
    steps = times_ms / step_ms
    ticks = np.ceil(steps - _ROUNDING)
    between = np.flatnonzero(ticks - steps > _ROUNDING)
    if between.size:
        first = between[0]
        yield label, float(times_ms[first]), float(ticks[first]) * step_ms
