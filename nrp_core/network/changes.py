"""Changes of a network while it runs, checked: parameters of cells, weights of synapses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray, IntArray
from nrp_core._support.checked_arguments import require_kind
from nrp_core.errors import CapabilityError, NetworkError, did_you_mean
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.limits import (
    check_spike_times,
    check_synapses,
    check_values,
    limits_of_cells,
    limits_of_synapses,
)
from nrp_core.network.modulations import follows_dopamine

PARAMETERS: Final = "parameters"
WEIGHTS: Final = "weights"
PLASTICITY: Final = "plasticity"
EQUATIONS: Final = "equations"
"""Parameters of synapses in equations."""
ELIGIBILITY: Final = "eligibility"
DOPAMINE: Final = "dopamine"
SYNAPSE_STATE: Final = frozenset({ELIGIBILITY, DOPAMINE})
"""What synapses that learn from rewards show besides their weights."""


@dataclass(frozen=True, slots=True)
class ParameterChange:
    """New parameters of some cells of one population.

    Args:
        label: the population's label.
        index: the cells' indices within the population, shape ``(n,)``.
        values: new values by PyNN name, in PyNN's units, each of shape ``(n,)``.
    """

    label: str
    index: IntArray
    values: Mapping[str, FloatArray]


@dataclass(frozen=True, slots=True)
class Synapses:
    """The synapses of a projection at some time.

    Args:
        pre_index, post_index: cells within their populations, shape ``(n_synapses,)``.
        weight: in PyNN's units, shape ``(n_synapses,)``.
        delay_ms: shape ``(n_synapses,)``.
    """

    pre_index: IndexArray
    post_index: IndexArray
    weight: FloatArray
    delay_ms: FloatArray


@dataclass(frozen=True, slots=True)
class Rewirings:
    """The synapses of a projection that formed and vanished, in this order.

    Args:
        time_ms: shape ``(n_changes,)``.
        pre_index, post_index: cells within their populations, shape ``(n_changes,)``.
        formed: whether it is a new synapse, shape ``(n_changes,)``.
    """

    time_ms: FloatArray
    pre_index: IndexArray
    post_index: IndexArray
    formed: npt.NDArray[np.bool_]


def lasting(projection: Projection) -> Projection:
    """Return a projection whose synapses stay the same ones.

    Raises:
        CapabilityError: they form and vanish.
    """
    if projection.rewiring is not None:
        raise CapabilityError(
            f"projection '{projection.label}': its synapses form and vanish while the network runs, so a "
            "list of weights has no meaning; read_synapses returns those that there are"
        )
    return projection


def learning(projection: Projection) -> Projection:
    """Return a plastic projection.

    Raises:
        NetworkError: it is static.
    """
    if not projection.is_plastic:
        raise NetworkError(
            f"projection '{projection.label}' ({projection.synapse_type}) does not learn, so its learning "
            "can neither stop nor continue; only a plastic projection such as one of STDP does"
        )
    return projection


def rewired(projection: Projection) -> Projection:
    """Return a projection whose synapses form and vanish.

    Raises:
        NetworkError: they stay the same ones.
    """
    if projection.rewiring is None:
        raise NetworkError(
            f"projection '{projection.label}': its synapses stay the same ones; those with structural "
            "plasticity form and vanish"
        )
    return projection


def rewarded(network: Network, label: str) -> Projection:
    """Return a projection whose synapses learn from rewards.

    Raises:
        NetworkError: the projection does not exist, its weights stay, or nothing says how rewards act on it.
    """
    projection = projection_of(network, label)
    if projection.neuromodulation is not None:
        raise NetworkError(
            f"projection '{label}' brings rewards; name the one onto '{projection.post}' whose weights change"
        )
    if not follows_dopamine(projection):
        raise NetworkError(
            f"projection '{label}': its synapses are of the type {projection.synapse_type}; rewards act on "
            "changes by STDP"
        )
    if not any(one.post == projection.post and one.neuromodulation for one in network.projections):
        raise NetworkError(
            f"projection '{label}' does not learn from rewards: no projection of Neuromodulation onto "
            f"'{projection.post}' says how they act"
        )
    return projection


def with_synapse_state(network: Network, label: str, variable: str) -> Projection:
    """Return a projection whose synapses have a state variable.

    Raises:
        NetworkError: the projection or the variable does not exist.
    """
    projection = projection_of(network, label)
    if projection.equations is None:
        return rewarded(network, label)
    model = projection.equations.model
    if variable in model.variables or (variable == DOPAMINE and model.eligibility):
        return projection
    known = [*model.variables, *([DOPAMINE] if model.eligibility else [])]
    raise NetworkError(
        f"projection '{label}': its equations have no state variable '{variable}'"
        f"{did_you_mean(variable, known)}"
    )


def parameter_changes(
    network: Network, neurons: IntArray, values: Mapping[str, npt.ArrayLike]
) -> list[ParameterChange]:
    """Return new values of cells, population by population.

    Args:
        network: the network.
        neurons: global ids.
        values: new values by PyNN name: one number for all neurons, or one for each.

    Raises:
        NetworkError: a population has no such parameter, or a value is impossible.
    """
    require_kind("set_parameters", "values", Mapping, values)
    each = {name: one_for_each(name, value, len(neurons)) for name, value in values.items()}
    changes = []
    for label, population in network.populations.items():
        first = network.offsets[label]
        chosen = (neurons >= first) & (neurons < first + population.size)
        if not chosen.any():
            continue
        for name in each:
            if name not in population.parameters:
                hint = did_you_mean(name, population.parameters)
                raise NetworkError(f"population '{label}' ({population.cell_type}) has no '{name}'{hint}")
        change = ParameterChange(label, neurons[chosen] - first, {n: v[chosen] for n, v in each.items()})
        check_values(
            f"population '{label}'", change.values,
            lambda i, c=change: f"cell {c.index[i]}",  # type: ignore[misc]
            limits=limits_of_cells(population.equations),
        )  # fmt: skip
        changes.append(change)
    return changes


def parameters_after(
    population: Population, changed: Mapping[str, FloatArray], change: ParameterChange
) -> dict[str, FloatArray]:
    """Return the changed parameters of a population after one more change, each of shape ``(size,)``."""
    after = dict(changed)
    for name, values in change.values.items():
        after[name] = np.array(changed.get(name, population.parameters[name]), float)
        after[name][change.index] = values
    return after


def synapse_parameters(
    network: Network, label: str, values: Mapping[str, npt.ArrayLike]
) -> tuple[Projection, dict[str, FloatArray]]:
    """Return a projection whose synapses are in equations, and new parameters, one for each synapse.

    Raises:
        NetworkError: the projection or parameter does not exist, or a value is impossible.
    """
    require_kind("set_synapse_parameters", "values", Mapping, values)
    projection = projection_of(network, label)
    if projection.equations is None:
        raise NetworkError(
            f"projection '{label}' ({projection.synapse_type}): parameters of synapses can change while the "
            "network runs if their law is given as equations (EquationSynapse)"
        )
    each = {name: one_for_each(name, value, projection.size) for name, value in values.items()}
    together = {**projection.synapse_parameters, **each}
    owner = f"projection '{label}'"
    check_values(owner, each, lambda i: f"synapse {i}", limits=limits_of_synapses(projection.equations))
    projection.equations.require_values(owner, lambda i: f"synapse {i}", together)
    return projection, each


def spike_trains(
    network: Network, label: str, trains: Sequence[npt.ArrayLike], cells: npt.ArrayLike | None
) -> tuple[IntArray, list[FloatArray]]:
    """Return the cells of a population that get new spike trains (by default all), and the trains (ms).

    Raises:
        NetworkError: not a SpikeSourceArray population, or times do not ascend from 0.
    """
    population = network.populations.get(label)
    if population is None or population.cell_type != "SpikeSourceArray":
        raise NetworkError(f"'{label}' is not a population of SpikeSourceArray cells")
    index = np.arange(population.size)
    index = index if cells is None else index[np.atleast_1d(np.asarray(cells, dtype=np.int64))]
    if len(trains) != len(index):
        raise NetworkError(f"population '{label}': {len(trains)} spike trains for {len(index)} cells")
    arrays = [np.asarray(train, dtype=float) for train in trains]
    check_spike_times(f"population '{label}'", arrays)
    return index, arrays


def projection_of(network: Network, label: str) -> Projection:
    """Return the projection with this label.

    Raises:
        NetworkError: the network has no such projection.
    """
    labels = [projection.label for projection in network.projections]
    if label not in labels:
        raise NetworkError(f"the network has no projection '{label}'{did_you_mean(label, labels)}")
    return network.projections[labels.index(label)]


def new_weights(network: Network, label: str, weights: npt.ArrayLike) -> FloatArray:
    """Return new weights of a projection, one for each synapse.

    Raises:
        NetworkError: the projection does not exist, or a weight is impossible.
    """
    projection = projection_of(network, label)
    each = one_for_each("weight", weights, projection.size)
    conductance_based = network.populations[projection.post].is_conductance_based
    check_synapses(
        f"projection '{label}'", projection.ends, {"weight": each},
        receptor=projection.receptor, conductance_based=conductance_based, signed=conductance_based,
    )  # fmt: skip
    return each


def one_for_each(name: str, value: npt.ArrayLike, n: int) -> FloatArray:
    """Return ``n`` numbers, given all of them or one.

    Raises:
        NetworkError: it is neither.
    """
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise NetworkError(f"{name} is {value!r:.60}; it must be a number, or one for each") from None
    if array.ndim and array.shape != (n,):
        given = f"an array of shape {array.shape}" if array.ndim > 1 else array.size
        raise NetworkError(f"{name} takes one value or {n}, not {given}")
    return np.broadcast_to(array, (n,)).copy()
