"""Implausible values of cells and synapses: valid, but far from any real neuron; most are in the wrong unit.

The ranges are a hundred times wider than those measured in neurons (NeuroElectro: Tripathy et al.,
Frontiers in Neuroinformatics 8:40, 2014, membrane time constants of 2 to 100 ms and capacitances of 10 to
1000 pF). So engineered models pass, and most values that are 1000 times too small or too large do not.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.cells import CELLS
from nrp_core.brain.network.data import RECEPTORS, Network, Population, Projection
from nrp_core.brain.network.drawing import extremes
from nrp_core.brain.network.equations.cell_doubts import doubts_about_cells, doubts_about_weights
from nrp_core.brain.network.equations.synapse_doubts import doubts_about_synapses
from nrp_core.brain.network.indices import stored_form
from nrp_core.brain.network.learning_doubts import doubts_about_learning
from nrp_core.brain.network.limits import distinct


class Plausible(NamedTuple):
    """A range of positive values in PyNN's unit, and the units that are 1000 times larger and smaller."""

    low: float
    high: float
    unit: str
    larger: str
    smaller: str


_TIME: Final = Plausible(0.05, 10_000.0, "ms", "s", "us")
_ENDLESS_MS: Final = 1e12
"""A time constant from which a state is meant not to decay; no unit of time is so far from ms."""
_SHORT_TIME: Final = Plausible(0.01, 1_000.0, "ms", "s", "us")
_CELLS: Final = {
    "tau_m": _TIME,
    "tau_syn_E": _TIME,
    "tau_syn_I": _TIME,
    "tau_refrac": _SHORT_TIME,
    "cm": Plausible(6e-4, 50.0, "nF", "uF", "pF"),  # none has less than 1 pF; 0.6 nF is not a few pF
    "tau_w": Plausible(0.16, 1e5, "ms", "s", "us"),
    "delta_T": Plausible(0.008, 500.0, "mV", "V", "uV"),
    "i_offset": Plausible(0.0, 50.0, "nA", "uA", "pA"),
    "b": Plausible(0.0, 10.0, "nA", "uA", "pA"),
    "a": Plausible(0.0, 1_000.0, "nS", "uS", "pS"),
    "gbar_Na": Plausible(0.02, 5_000.0, "uS", "mS", "nS"),
    "gbar_K": Plausible(0.006, 1_500.0, "uS", "mS", "nS"),
}
_IZHIKEVICH: Final = {"i_offset": Plausible(0.0, 1.0, "nA", "uA", "pA")}
"""Its published currents, in units of pA for 1 ms, are 2 to 20 (Izhikevich 2003)."""
_VOLTAGES: Final = ("v_rest", "v_reset", "v_thresh", "e_rev_E", "e_rev_I")
_REST_V: Final = (-0.1, -0.02)
"""Resting potentials of neurons, V; a model in volts has one of these where millivolts are expected."""
_HIGHEST_MV: Final = 1_000.0
_IN_MV: Final = frozenset(cell.name for cell in CELLS.values() if cell.weight_unit == "mV")
"""Cells with weights that are voltages, not currents."""
_ROUNDING: Final = 1e-6
_DELAY: Final = Plausible(0.01, 500.0, "ms", "s", "us")
_LEARNS: Final = Plausible(0.5, 10_000.0, "ms", "s", "us")
_RECOVERS: Final = _LEARNS._replace(low=1.0)
"""Resources recover in about a second (Tsodyks and Markram 1997: 0.8 s)."""
_MEMORIES: Final = {"tau_rec": _RECOVERS, "tau_facil": _LEARNS, "tau_plus": _LEARNS, "tau_minus": _LEARNS}
"""Time constants of plasticity."""
_USUAL_HIGHEST: Final = 1.0
"""What PyNN's rules of spike-timing-dependent plasticity take for ``w_max`` if a script does not set it."""
_AT_ONCE_MS: Final = 1e-6
"""The longest time constant that stands for none: a nanosecond, the resolution of time."""
HIGHEST_HZ: Final = 1e5
"""Of one Poisson source, which often stands for thousands of neurons."""
FEWEST_SPIKES: Final = 0.5
"""Mean number of spikes of all sources together below which most runs have none."""
_VOLLEY_MS: Final = 10.0
"""The longest activity in which most sources do not fire once; a longer one is sparse, as in cortex."""
_SHORTEST_MS: Final = 0.5
"""Of the intervals of one source; no neuron fires at 2 kHz."""
_STEP: Final = Plausible(0.002, 100.0, "ms", "s", "us")  # 0.001 is a millisecond in s
_STRONGEST: Final = 50.0
"""Conductance of one synapse in units of the leak; more takes a cell to the reversal potential."""
_NOTICED: Final = 0.01
"""The smallest effect of a projection, as a share of the distance from rest to threshold."""
_NOTHING: Final = np.empty(0)
_LARGEST_EFFECT: Final = 1_000.0
"""Limits of one spike: the voltage that its current causes, mV, or its conductance in units of the leak."""


def implausible(network: Network) -> list[str]:
    """Return a sentence for each implausible value, and for each synapse outside its own limits.

    Args:
        network: the network; without parameters, as in a description, there is nothing to check.
    """
    found: list[str] = []
    if network.timestep_ms is not None:
        found += _outside("timestep of setup", np.array([network.timestep_ms]), _STEP)
    for population in network.populations.values():
        found += _of_cells(population, network.timestep_ms)
    for projection in network.projections:
        post = network.populations[projection.post]
        found += _of_synapses(projection, post)
        found += _within_step(projection, network.timestep_ms)
        found += _of_all_together(projection, post)
    return found


def _of_cells(population: Population, step_ms: float | None) -> Iterator[str]:
    owner = f"the population '{population.label}'"
    if population.equations is not None:
        found = doubts_about_cells(
            population.equations, population.parameters, population.initial_values, step_ms
        )
        yield from (f"the equations of {owner}: {doubt}" for doubt in dict.fromkeys(found))
        return
    plausibles = _IZHIKEVICH if population.cell_type == "Izhikevich" else _CELLS
    for name, plausible in plausibles.items():
        if name in population.parameters:
            values = population.parameters[name]
            decaying = values[values < _ENDLESS_MS] if plausible is _TIME else values
            yield from _outside(f"{name} of {owner}", decaying, plausible)
    for name in _VOLTAGES:
        yield from _in_volts(f"{name} of {owner}", population.parameters.get(name, np.empty(0)))
    yield from _of_threshold(owner, population)
    yield from _of_offset(owner, population)
    yield from _of_beginning(owner, population)
    excites, inhibits = (population.parameters.get(f"e_rev_{kind}", np.zeros(1)) for kind in "EI")
    if (inhibits > excites).any():
        pair = f"{inhibits.max():g} mV, above e_rev_E, {excites.min():g} mV"
        yield f"e_rev_I of {owner} is {pair}: are they swapped?"
    else:
        yield from _of_reversals(owner, population)
    intervals = [np.diff(times) for times in population.spike_times_ms if len(times) > 1]
    if intervals and 0 < (usual := np.median(np.concatenate(intervals))) <= _SHORTEST_MS:
        yield f"spikes of {owner} follow each other after {usual:g} ms; is it meant in s?"
    if population.cell_type == "SpikeSourcePoisson" and population.parameters:
        yield from _of_poisson(owner, population)
    if population.cell_type == "Izhikevich" and (population.parameters.get("a", np.ones(1)) <= 0.0).any():
        a, c = (float(population.parameters[name][0]) for name in "ac")
        yield f"a of {owner} is {a:g} /ms, and c is {c:g} mV: u does not recover; are they swapped?"


def _of_reversals(owner: str, population: Population) -> Iterator[str]:
    """Yield the synaptic inputs that act against their name."""
    cells = population.parameters
    if not {"e_rev_E", "e_rev_I", "v_rest", "v_thresh"} <= cells.keys():
        return
    if (cells["e_rev_E"] <= cells["v_rest"]).any():
        pair = f"{cells['e_rev_E'].min():g} mV, and v_rest {cells['v_rest'].max():g} mV"
        yield f"e_rev_E of {owner} is {pair}: excitatory input inhibits"
    if (cells["e_rev_I"] >= np.maximum(cells["v_thresh"], cells["v_rest"])).any():
        pair = f"{cells['e_rev_I'].max():g} mV, and v_thresh {cells['v_thresh'].min():g} mV"
        yield f"e_rev_I of {owner} is {pair}: inhibitory input makes cells fire"


def _of_threshold(owner: str, population: Population) -> Iterator[str]:
    """Yield the thresholds that no input reaches, and the cells without the current that makes a spike."""
    cells = population.parameters
    if "gbar_Na" in cells and not cells["gbar_Na"].any():
        yield f"gbar_Na of {owner} is 0: its cells cannot fire"
    if not {"v_thresh", "v_rest"} <= cells.keys() or "delta_T" in cells:
        return
    threshold, rest = cells["v_thresh"], cells["v_rest"]
    mirrored = (threshold > 0.0) & (rest < -threshold)
    if mirrored.any():
        high, low = threshold[mirrored][0], rest[mirrored][0]
        yield f"v_thresh of {owner} is {high:g} mV, {high - low:g} mV above v_rest: is a sign wrong?"
    elif "e_rev_E" in cells and ((cells["e_rev_E"] <= threshold) & (cells["e_rev_E"] > rest)).any():
        pair = f"{cells['e_rev_E'].min():g} mV, and v_thresh {threshold.max():g} mV"
        yield f"e_rev_E of {owner} is {pair}: no excitatory input takes a cell to its threshold"


def _of_poisson(owner: str, sources: Population) -> Iterator[str]:
    rates, durations_ms = sources.parameters["rate"], sources.parameters["duration"]
    if rates.max() > HIGHEST_HZ:
        yield f"rate of {owner} is {rates.max():g} Hz; is it meant in mHz?"
    fires = rates > 0.0
    expected = float((rates[fires] * durations_ms[fires] / 1000.0).sum())
    is_brief = durations_ms[fires].max(initial=0.0) <= _VOLLEY_MS
    if 0 < expected < FEWEST_SPIKES * (int(fires.sum()) if is_brief else 1):
        yield (
            f"{owner} fires {expected:.2g} spikes in all: the duration is {durations_ms.max():g} ms; "
            "is it meant in s?"
        )


def _of_offset(owner: str, population: Population) -> Iterator[str]:
    """Yield that no cell notices its constant current."""
    cells = population.parameters
    if not {"i_offset", "tau_m", "cm", "v_rest", "v_thresh"} <= cells.keys() or not cells["i_offset"].any():
        return
    effects_mv = np.abs(cells["i_offset"]) * cells["tau_m"] / cells["cm"]
    distance_mv = float(np.abs(cells["v_thresh"] - cells["v_rest"]).min())
    if np.isfinite(distance_mv) and effects_mv.max() < _NOTICED * distance_mv:
        size = f"{np.abs(cells['i_offset']).max():g} nA, which moves a cell by {effects_mv.max():.2g} mV"
        yield f"i_offset of {owner} is {size}; is it meant in uA?"


def _of_beginning(owner: str, population: Population) -> Iterator[str]:
    """Yield what is wrong with the initial membrane potential; cells that rest above threshold may fire."""
    cells, begins = population.parameters, population.initial_values.get("v", np.empty(0))
    if not begins.size or not {"v_rest", "v_thresh"} <= cells.keys() or "delta_T" in cells:
        return
    rest, threshold = cells["v_rest"], cells["v_thresh"]
    in_volts = list(_in_volts(f"the initial v of {owner}", begins)) if (np.abs(rest) > 1.0).all() else []
    yield from in_volts
    above = (begins >= threshold) & (rest < threshold)
    if above.any() and not in_volts:
        first = int(np.flatnonzero(above)[0])
        yield (
            f"{int(above.sum())} of {population.size} cells of {owner} begin at or above their threshold and "
            f"fire at once: v is {begins[first]:g} mV, and v_thresh is {threshold[first]:g} mV"
        )


def _outside(owner: str, values: FloatArray, plausible: Plausible) -> Iterator[str]:
    sizes = np.abs(values[values != 0])
    if not sizes.size:
        return
    low, high, unit, larger, smaller = plausible
    for size, is_wrong, meant in (
        (sizes.min(), sizes.min() < low, larger),
        (sizes.max(), sizes.max() > high, smaller),
    ):
        if is_wrong:
            yield f"{owner} is {size:g} {unit}; is it meant in {meant}?"


def _in_volts(owner: str, values: FloatArray) -> Iterator[str]:
    values = values[np.isfinite(values)]  # without a threshold, cells never fire
    if not values.size:
        return
    low, high = _REST_V
    if low <= values.min() and values.max() <= high:
        yield f"{owner} is {values.flat[0]:g} mV; is it meant in V?"
    elif np.abs(values).max() > _HIGHEST_MV:
        yield f"{owner} is {values[np.abs(values).argmax()]:g} mV; is it meant in uV?"


def _of_synapses(projection: Projection, post: Population) -> Iterator[str]:
    if not projection.size or projection.neuromodulation is not None:
        return
    owner = f"the projection '{projection.label}'"
    yield from _outside(f"a delay of {owner}", _extremes(projection, "delay_ms"), _DELAY)
    if projection.equations is not None:
        scale = projection.equations.weight_scale(post.weight_unit(projection.receptor))
        sizes = np.abs(projection.weight) * scale
        found = doubts_about_synapses(projection.equations, projection.synapse_parameters, sizes)
        yield from (f"the equations of {owner}: {doubt}" for doubt in dict.fromkeys(found))
    if post.equations is not None and projection.receptor in RECEPTORS:
        cells = post.equations, post.parameters, post.initial_values
        against = doubts_about_weights(*cells, projection.receptor, _extremes(projection, "weight"))
        yield from (f"the equations of the population '{post.label}', at {owner}: {one}" for one in against)
    for name, plausible in _MEMORIES.items():
        if name in projection.synapse_parameters:
            values = projection.synapse_parameters[name]
            yield from _outside(f"{name} of {owner}", values[values > _AT_ONCE_MS], plausible)
    yield from doubts_about_learning(owner, projection)
    yield from _of_weights(owner, projection, post)
    if "U" in projection.synapse_parameters and not projection.synapse_parameters["U"].any():
        yield f"U of {owner} is 0: its synapses never transmit"


def _within_step(projection: Projection, step_ms: float | None) -> Iterator[str]:
    """Yield that a delay ends within a time step; a delay of 0 is deliberate."""
    if step_ms is None or not projection.size:
        return
    shortest = float(_extremes(projection, "delay_ms").min())
    if _DELAY.low <= shortest < step_ms * (1.0 - _ROUNDING):
        yield (
            f"a delay of the projection '{projection.label}' is {shortest:g} ms, shorter than the time step "
            f"of {step_ms:g} ms; is it meant in s?"
        )


def _of_weights(owner: str, projection: Projection, post: Population) -> Iterator[str]:
    """Yield that weights, or what they may grow to, are too large or all 0."""
    limits = {} if projection.equations is not None else projection.synapse_parameters
    weights = _extremes(projection, "weight")
    if not weights.size:
        return
    size = too_strong(_largest(weights), post)
    if size:
        yield f"a weight of {owner} is {size}"
    of_currents = post.equations is None and not post.is_conductance_based
    if of_currents and projection.receptor == "inhibitory" and weights.max() > 0.0:
        yield f"weights of {owner} are positive on the inhibitory receptor of currents: they excite"
    highest = limits.get("w_max", _NOTHING)
    size = too_strong(float(highest.max()), post) if highest.size and not size else ""
    if size:
        whose = ", PyNN's default" if (highest == _USUAL_HIGHEST).all() else ""
        yield f"w_max of {owner}{whose} is {size}"
    formed = 0.0 if projection.rewiring is None else projection.rewiring.initial_weight
    if not weights.any() and not formed and "w_max" not in projection.synapse_parameters:
        yield f"all weights of {owner} are 0: it has no effect"


def too_strong(weight: float, post: Population) -> str:
    """Return a weight with its effect on a cell if that is implausibly large, or else an empty text."""
    if post.cell_type in _IN_MV:
        return f"{weight:g} mV; is it meant in uV?" if weight > _LARGEST_EFFECT else ""
    leak = _leak_us(post)
    if leak is None or weight <= (_STRONGEST if post.is_conductance_based else _LARGEST_EFFECT) * leak:
        return ""
    if post.is_conductance_based:
        return f"{weight:g} uS, {weight / leak:.3g} times the leak of a cell; is it meant in nS?"
    return f"{weight:g} nA, which leads to {weight / leak:.3g} mV; is it meant in pA?"


def too_weak(weight: float, post: Population) -> str:
    """Return a weight with its effect if no rate of one source takes a cell to its threshold by it.

    The effect is the mean voltage that ``HIGHEST_HZ`` cause in a cell at rest.
    """
    cells, in_mv = post.parameters, post.cell_type in _IN_MV
    needed = {"cm", "tau_m", "v_rest", "v_thresh"} | (set() if in_mv else {"tau_syn_E", "tau_syn_I"})
    needed |= {"e_rev_E", "e_rev_I"} if post.is_conductance_based else set()
    if post.equations is not None or not needed <= cells.keys() or not post.size or not weight:
        return ""
    distance_mv = float((cells["v_thresh"] - cells["v_rest"]).min())
    if not 0.0 < distance_mv < np.inf:  # pacemakers, and cells that never fire
        return ""
    effect_mv = weight * HIGHEST_HZ / 1000.0 * float(cells["tau_m"].max())
    if not in_mv:  # an alpha function is e times as large as an exponential one of its height
        longest_ms = float(max(cells["tau_syn_E"].max(), cells["tau_syn_I"].max()))
        effect_mv *= np.e * longest_ms / float(cells["cm"].min())
    if post.is_conductance_based:
        forces = [np.abs(cells[f"e_rev_{kind}"] - cells["v_rest"]) for kind in "EI"]
        effect_mv *= float(np.max(forces))
    if effect_mv >= distance_mv:
        return ""
    unit = "mV" if in_mv else ("uS" if post.is_conductance_based else "nA")
    return (
        f"{weight:g} {unit}: even {HIGHEST_HZ:.0f} spikes a second move a cell by {effect_mv:.2g} mV, and "
        f"its threshold is {distance_mv:g} mV above its resting potential; is it in another unit?"
    )


def _of_all_together(projection: Projection, post: Population) -> Iterator[str]:
    """Yield that no cell notices a projection, even if all its synapses are active at once."""
    cells, name = post.parameters, f"tau_syn_{'E' if projection.receptor == 'excitatory' else 'I'}"
    needed = {"cm", "v_rest", "v_thresh"} | (set() if post.cell_type in _IN_MV else {name})
    if projection.receptor not in RECEPTORS or not projection.size:
        return
    if not needed <= cells.keys() or "w_max" in projection.synapse_parameters:
        return
    distances_mv = cells["v_thresh"] - cells["v_rest"]
    distance_mv = float(distances_mv[distances_mv > 0].min(initial=np.inf))  # others are pacemakers
    if not np.isfinite(distance_mv):
        return
    effect_mv = _largest(_extremes(projection, "weight"))
    suspect = "the weight"
    if post.cell_type not in _IN_MV:
        effect_mv *= float(cells[name].max()) * np.e / float(cells["cm"].min())
        suspect += f", or cm ({float(cells['cm'].min()):g} nF),"
    if post.is_conductance_based:
        reversal = cells["e_rev_E" if projection.receptor == "excitatory" else "e_rev_I"]
        effect_mv *= float(np.abs(reversal - cells["v_rest"]).max())
    if 0 < effect_mv < _NOTICED * distance_mv:  # of one synapse
        effect_mv *= _most_onto_a_cell(projection)
    if 0 < effect_mv < _NOTICED * distance_mv:
        yield (
            f"all synapses of the projection '{projection.label}' together move a cell by {effect_mv:.2g} mV "
            f"at most, and its threshold is {distance_mv:g} mV above its resting potential: is {suspect} in "
            "another unit?"
        )


def _most_onto_a_cell(projection: Projection) -> int:
    counts = np.zeros(0, np.int64)
    for _, post in projection.pairs():
        more = np.bincount(post, minlength=len(counts))
        more[: len(counts)] += counts
        counts = more
    return int(counts.max())


def _leak_us(cells: Population) -> float | None:
    """Return the smallest leak conductance of cells that leak, uS (nF/ms); None if none does."""
    if not {"cm", "tau_m"} <= cells.parameters.keys() or cells.cell_type in _IN_MV:
        return None
    leaks = cells.parameters["tau_m"] < _ENDLESS_MS
    leak = float((cells.parameters["cm"] / cells.parameters["tau_m"])[leaks].min(initial=np.inf))
    return leak if 0.0 < leak < np.inf else None  # equations may have any sign


def _extremes(projection: Projection, name: str) -> FloatArray:
    """Return values of a projection; one if all share it, two if those between would be drawn again."""
    return distinct(extremes(stored_form(projection, name)))


def _largest(values: FloatArray) -> float:
    """Return the largest size of values, without a copy of all of them."""
    return max(-float(values.min()), float(values.max()))
