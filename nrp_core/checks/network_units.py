"""Values of cells and synapses that are probably in another unit than PyNN's: ms, mV, nF, nA, uS and Hz.

The ranges are a hundred times wider than those measured in neurons (NeuroElectro: Tripathy et al.,
Frontiers in Neuroinformatics 8:40, 2014, membrane time constants of 2 to 100 ms and capacitances of 10 to
1000 pF). So engineered models pass, and most values that are 1000 times too small or too large do not.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.checks.synaptic_effects import HIGHEST_DEVICE_HZ, NEVER_MV, effect_of_spike
from nrp_core.clock import nanoseconds
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.drawing import extremes
from nrp_core.network.indices import stored_form
from nrp_core.network.limits import distinct


class Range(NamedTuple):
    """A range of positive values in PyNN's unit, and the units that are 1000 times larger and smaller."""

    low: float
    high: float
    unit: str
    larger: str
    smaller: str


TIME: Final = Range(0.05, 10_000.0, "ms", "s", "us")
ENDLESS_MS: Final = 1e12
"""A time constant from which a state does not decay."""
CELL_RANGES: Final = {
    "tau_m": TIME,
    "tau_syn_E": TIME,
    "tau_syn_I": TIME,
    "tau_refrac": Range(0.01, 1_000.0, "ms", "s", "us"),
    "cm": Range(6e-4, 50.0, "nF", "uF", "pF"),  # none has less than 1 pF; 0.6 nF is not a few pF
    "tau_w": Range(0.16, 1e5, "ms", "s", "us"),
    "delta_T": Range(0.008, 500.0, "mV", "V", "uV"),
    "i_offset": Range(0.0, 50.0, "nA", "uA", "pA"),
    "b": Range(0.0, 10.0, "nA", "uA", "pA"),
    "a": Range(0.0, 1_000.0, "nS", "uS", "pS"),
    "gbar_Na": Range(0.02, 5_000.0, "uS", "mS", "nS"),
    "gbar_K": Range(0.006, 1_500.0, "uS", "mS", "nS"),
}
IZHIKEVICH_RANGES: Final = {"i_offset": Range(0.0, 1.0, "nA", "uA", "pA")}
"""The published currents, in units of pA for 1 ms, are 2 to 20 (Izhikevich 2003)."""
VOLTAGES: Final = ("v_rest", "v_reset", "v_thresh", "e_rev_E", "e_rev_I")
REST_V: Final = (-0.1, -0.02)
"""Resting potentials of neurons, V; a model in volts has one of these where millivolts are expected."""
HIGHEST_MV: Final = 1_000.0
DELAY: Final = Range(0.01, 500.0, "ms", "s", "us")
LEARNING: Final = Range(0.5, 10_000.0, "ms", "s", "us")
SYNAPSE_RANGES: Final = {
    "tau_rec": LEARNING._replace(low=1.0),  # about a second (Tsodyks and Markram 1997: 0.8 s)
    "tau_facil": LEARNING,
    "tau_plus": LEARNING,
    "tau_minus": LEARNING,
}
INSTANT_MS: Final = 1e-6
"""The longest time constant that stands for none: a nanosecond, the resolution of time."""
TIME_STEP: Final = Range(0.002, 100.0, "ms", "s", "us")  # 0.001 is a millisecond in s
SHORTEST_INTERVAL_MS: Final = 0.5
"""Of the spikes of one source; no neuron fires at 2 kHz."""
STRONGEST_PSP_MV: Final = 500.0
"""Largest effect of one spike on a cell at rest: 25 times the usual distance to threshold, 20 mV."""
STRONGEST_CONDUCTANCE_MV: Final = 3000.0
"""The same without saturation at the reversal potential, which scripts use to make a cell fire for sure."""


def unlikely_units(network: Network) -> list[str]:
    """Return a sentence for each value that is probably in another unit.

    Args:
        network: the network; without parameters, as in a description, it passes.
    """
    found: list[str] = []
    if network.timestep_ms is not None:
        found += outside("timestep of setup", np.array([network.timestep_ms]), TIME_STEP)
    for population in network.populations.values():
        found += _check_cells(population)
    for projection in network.projections:
        if projection.size and projection.neuromodulation is None and not projection.is_continuous:
            found += _check_synapses(projection, network.populations[projection.post], network.timestep_ms)
    return found


def _check_cells(population: Population) -> Iterator[str]:
    owner, cells = f"the population '{population.label}'", population.parameters
    if population.equations is not None:  # in units of their own
        return
    ranges = IZHIKEVICH_RANGES if population.cell_type == "Izhikevich" else CELL_RANGES
    for name in sorted(ranges.keys() & cells.keys()):
        values_of = cells[name][cells[name] < ENDLESS_MS] if ranges[name] is TIME else cells[name]
        yield from outside(f"{name} of {owner}", values_of, ranges[name])
    for name in VOLTAGES:
        yield from _in_volts(f"{name} of {owner}", cells.get(name, np.empty(0)))
    if np.abs(cells.get("v_rest", np.zeros(1))).min(initial=np.inf) > 1.0:
        yield from _in_volts(f"the initial v of {owner}", population.initial_values.get("v", np.empty(0)))
    intervals = [np.diff(train) for train in population.spike_times_ms if len(train) > 1]
    if intervals and 0 < (usual := np.median(np.concatenate(intervals))) <= SHORTEST_INTERVAL_MS:
        yield f"spikes of {owner} follow each other after {usual:g} ms; is it meant in s?"
    if population.cell_type == "SpikeSourcePoisson" and cells and cells["rate"].max() > HIGHEST_DEVICE_HZ:
        yield f"rate of {owner} is {cells['rate'].max():g} Hz; is it meant in mHz?"


def _check_synapses(projection: Projection, post: Population, step_ms: float | None) -> Iterator[str]:
    owner, parameters = f"the projection '{projection.label}'", projection.synapse_parameters
    delays_ms = _extremes(projection, "delay_ms")
    yield from outside(f"a delay of {owner}", delays_ms, DELAY)
    if (
        step_ms is not None
        and delays_ms.min() >= DELAY.low
        and nanoseconds(delays_ms).min() < nanoseconds(step_ms)
    ):
        yield (
            f"a delay of {owner} is {delays_ms.min():g} ms, shorter than the time step of {step_ms:g} ms; is "
            "it meant in s?"
        )
    for name in sorted(SYNAPSE_RANGES.keys() & parameters.keys()) if projection.equations is None else ():
        values = parameters[name]
        yield from outside(f"{name} of {owner}", values[values > INSTANT_MS], SYNAPSE_RANGES[name])
    weights = _extremes(projection, "weight")
    size = too_strong(float(np.abs(weights).max()), post, projection.receptor)
    if size:
        yield f"a weight of {owner} is {size}"
    is_current = post.equations is None and not post.is_conductance_based
    if is_current and projection.receptor == "inhibitory" and weights.max() > 0.0:
        yield f"weights of {owner} are positive on the inhibitory receptor of currents: they excite"


def too_strong(weight: float, post: Population, receptor: str = "excitatory") -> str:
    """Return a weight with the effect of one spike if that is implausibly large, or else an empty text."""
    effect = effect_of_spike(post, receptor)
    limit_mv = STRONGEST_CONDUCTANCE_MV if post.is_conductance_based else STRONGEST_PSP_MV
    if effect is None or weight * effect.peak_mv <= limit_mv:
        return ""
    unit = str(post.weight_unit(receptor).text)
    smaller = {"mV": "uV", "uS": "nS"}.get(unit, "pA")
    return (
        f"{weight:g} {unit}, with which one spike moves a cell by {weight * effect.peak_mv:.3g} mV; is it "
        f"meant in {smaller}?"
    )


def outside(owner: str, values: FloatArray, plausible: Range) -> Iterator[str]:
    """Yield a text if values are too small or too large for their unit; 0 is neither."""
    values = values[values != 0]
    if not values.size:
        return
    low, high, unit, larger, smaller = plausible
    least, most = (values[pick(np.abs(values))] for pick in (np.argmin, np.argmax))
    if abs(least) < low:
        yield f"{owner} is {least:g} {unit}; is it meant in {larger}?"
    if abs(most) > high:
        yield f"{owner} is {most:g} {unit}; is it meant in {smaller}?"


def _in_volts(owner: str, values: FloatArray) -> Iterator[str]:
    values = values[values < NEVER_MV]
    if not values.size:
        return
    low, high = REST_V
    if low <= values.min() and values.max() <= high:
        yield f"{owner} is {values.flat[0]:g} mV; is it meant in V?"
    elif np.abs(values).max() > HIGHEST_MV:
        yield f"{owner} is {values[np.abs(values).argmax()]:g} mV; is it meant in uV?"


def _extremes(projection: Projection, name: str) -> FloatArray:
    """Return values of a projection: one if all are equal, two (the extremes) if they are random."""
    return distinct(extremes(stored_form(projection, name)))
