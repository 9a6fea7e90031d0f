"""A neural network as data: populations, projections, named views.

Every backend receives the same network; connectivity and random parameters were drawn once,
when it was built. Names and units are PyNN's: ms, mV, nF, nA, uS; weights in uS for
conductance-based and nA for current-based targets (mV for IF_curr_delta, IF_curr_exp_frozen and
Izhikevich), negative on the inhibitory receptor of current-based targets.

Neurons are addressed by *global ids*: they number all cells, population by population, in definition order.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import BoolArray, FloatArray, IndexArray, IntArray
from nrp_core._support.checked_arguments import checks_arguments, require_fields
from nrp_core._support.overview import Overview, Row, counted
from nrp_core.errors import NetworkError, NeuronSelectionError, did_you_mean
from nrp_core.network.cells import CELLS
from nrp_core.network.currents import InjectedCurrent, require_targets
from nrp_core.network.drawing import redrawn
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.equations.model import INHIBITORY
from nrp_core.network.equations.model import RECEPTORS as RECEPTORS
from nrp_core.network.equations.synapse import SynapseEquations
from nrp_core.network.frozen_values import (
    copy_mappings,
    feed,
    freeze_value,
    global_ids,
    require_all_parameters,
    require_cell_names,
    require_identity,
    require_numbers,
    require_own_labels,
    require_parts,
    require_synapse_names,
    require_timestep,
    require_values,
)
from nrp_core.network.indices import ends_of, folded, indices_of, stored_form
from nrp_core.network.limits import (
    check_cells,
    check_positions,
    check_spike_times,
    check_synapses,
    check_values,
    describing,
    limits_of_cells,
    limits_of_synapses,
)
from nrp_core.network.rewiring import MODULATORY, Neuromodulation, Rewiring
from nrp_core.network.synapses import CONTINUOUS, ELECTRICAL, LAWS, PLASTIC, STATIC
from nrp_core.network.voltages import require_voltages
from nrp_core.units import Unit, unit_of


@dataclass(frozen=True)
class Origin:
    """How a projection was made, for backends that need distributions instead of drawn values.

    Args:
        connector: PyNN's name of the connector, e.g. ``FixedProbabilityConnector``.
        parameters: its parameters: numbers, Booleans and strings; None for arrays.
        weight: the weight as given: a number, a distribution such as ``normal(mu=0.5, sigma=0.1)``, or a
            function of the distance ``d`` such as ``0.1*exp(-d)``; None if each synapse got its own.
        delay: the delay (ms) from the script, in the same form.
    """

    connector: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    weight: Any = None
    delay: Any = None


LISTED: Final = Origin("FromListConnector")
"""The origin of synapses that follow no rule."""


HINTS: Final = frozenset(
    {
        "neurons_per_core", "synapse_cores", "spikes_per_second", "ring_buffer_sigma",
        "max_summed_weight_exc", "max_summed_weight_inh", "n_steps_per_timestep",
    }
)  # fmt: skip
"""What a script may say about the place of a population on a machine, in the words of sPyNNaker."""


@dataclass(frozen=True)
class Population:
    """Cells of one type.

    Args:
        label: unique name within the network.
        size: number of cells.
        cell_type: PyNN's name of the standard cell, e.g. ``IF_cond_alpha``.
        parameters: every parameter of the cell type, PyNN names and units, shape ``(size,)``.
        initial_values: initial state variables (``v`` in mV, ...), shape ``(size,)``.
        spike_times_ms: for ``SpikeSourceArray``: one ascending array for each cell, else empty; several cells
            may have the same one.
        positions_um: shape ``(size, 3)``, or None where the model has no positions.
        hints: how a machine is to hold the population, e.g. ``neurons_per_core``, by the names of
            :data:`HINTS`; other backends ignore them.
        equations: the equations of the cells, if their type is ``EquationCell``; parameters and initial
            values are then in the units of the equations.

    Raises:
        NetworkError: a shape does not fit or a value is not finite.
    """

    label: str
    size: int
    cell_type: str
    parameters: Mapping[str, FloatArray]
    initial_values: Mapping[str, FloatArray] = field(default_factory=dict)
    spike_times_ms: tuple[FloatArray, ...] = ()
    positions_um: FloatArray | None = None
    hints: Mapping[str, float] = field(default_factory=dict)
    equations: CellEquations | None = None

    def __post_init__(self) -> None:
        require_identity(self.label, self.size)
        require_fields(self, f"population '{self.label}'", "cell_type", "spike_times_ms")
        copy_mappings(self, f"population '{self.label}'", "parameters", "initial_values", "hints")
        object.__setattr__(self, "spike_times_ms", tuple(map(freeze_value, self.spike_times_ms)))
        object.__setattr__(self, "positions_um", freeze_value(self.positions_um))
        for name in self.hints.keys() - HINTS:
            raise NetworkError(f"population '{self.label}' has no hint '{name}'{did_you_mean(name, HINTS)}")
        for kind, values in (("parameter", self.parameters), ("initial value", self.initial_values)):
            for name, array in values.items():
                require_numbers(f"population '{self.label}': {kind} '{name}'", array, self.size)
            check_values(f"population '{self.label}'", values, limits=limits_of_cells(self.equations))
        if self.equations is not None:
            self.equations.require_values(f"population '{self.label}'", self.parameters, self.initial_values)
        if self.spike_times_ms and len(self.spike_times_ms) != self.size:
            raise NetworkError(
                f"population '{self.label}' has {len(self.spike_times_ms)} spike trains for its "
                f"{self.size} cells"
            )
        if self.positions_um is not None:
            check_positions(f"population '{self.label}'", self.positions_um, self.size)
        check_spike_times(f"population '{self.label}'", self.spike_times_ms)

    @property
    def is_source(self) -> bool:
        """Whether the cells only emit spikes (``SpikeSourcePoisson``, ``SpikeSourceArray``)."""
        return self.cell_type.startswith("SpikeSource")

    @property
    def is_relay(self) -> bool:
        """Whether the cells only repeat spikes, as NEST's ``parrot_neuron`` does: currents have no meaning.

        A threshold within 1 pV of the reset and no refractory period: a current would make them fire forever.
        """
        own, needed = self.parameters, {"v_thresh", "v_reset", "tau_refrac"}
        if self.cell_type != "IF_curr_delta" or not self.size or not needed <= own.keys():
            return False
        return bool(((own["v_thresh"] - own["v_reset"] <= 1e-9) & (own["tau_refrac"] == 0)).all())

    @property
    def is_conductance_based(self) -> bool:
        """Whether synaptic weights are conductances in uS."""
        if self.equations is not None:
            return self.equations.model.is_conductance_based
        return "_cond_" in self.cell_type

    def receptor_number(self, receptor: str) -> int:
        """Return the number of a receptor: 0 for ``excitatory``, 1 for ``inhibitory``."""
        if self.equations is not None:
            return self.equations.model.receptor_number(receptor)
        return RECEPTORS.index(receptor)

    def weight_unit(self, receptor: str) -> Unit:
        """Return the unit of the weights of synapses onto a receptor."""
        if self.equations is not None:
            return self.equations.model.receptors[receptor].unit
        known = CELLS.get(self.cell_type)
        return unit_of(known.weight_unit if known else "uS" if self.is_conductance_based else "nA")


@redrawn("weight", "delay_ms")
@folded("pre_index", "post_index")
@dataclass(frozen=True)
class Projection:
    """Synapses from one population to another on one receptor.

    Args:
        label: unique name within the network.
        pre, post: labels of the populations.
        receptor: ``excitatory``, ``inhibitory``, another one of the equations of the target, or ``reward`` or
            ``punishment``.
        pre_index, post_index: cells within their populations, shape ``(n_synapses,)``; stored compressed,
            so use :meth:`pairs` to read a few at a time.
        weight: in the units of the target (see module), or uS if the synapses are electrical, shape
            ``(n_synapses,)``; equal weights may share memory (a broadcast array). Those of large projections
            may be drawn again for each read (:class:`~nrp_core.network.drawing.Drawn`).
        delay_ms: shape ``(n_synapses,)``, like the weights.
        synapse_type: name of the synapse law, see :mod:`nrp_core.network.synapses`.
        synapse_parameters: the law's parameters, PyNN names and units, shape ``(n_synapses,)``.
        plasticity: PyNN's class of each part of the law, if it has parts.
        origin: how the projection was made.
        equations: the law, if ``synapse_type`` is ``EquationSynapse``; its parameters are then in the units
            of the equations.
        initial_values: state variables of the law at time 0, by its names, shape ``(n_synapses,)``; the
            others are at rest.
        rewiring: how its synapses form and vanish, or None if they stay; those above are then the first ones.
        neuromodulation: how they decide on STDP, if the receptor is ``reward`` or ``punishment``; they do
            nothing else.
    """

    label: str
    pre: str
    post: str
    receptor: str
    pre_index: IndexArray
    post_index: IndexArray
    weight: FloatArray
    delay_ms: FloatArray
    synapse_type: str = STATIC
    synapse_parameters: Mapping[str, FloatArray] = field(default_factory=dict)
    plasticity: Mapping[str, str] = field(default_factory=dict)
    origin: Origin = LISTED
    equations: SynapseEquations | None = None
    initial_values: Mapping[str, FloatArray] = field(default_factory=dict)
    rewiring: Rewiring | None = None
    neuromodulation: Neuromodulation | None = None

    def __post_init__(self) -> None:
        owner = f"projection '{self.label}'"
        require_fields(self, owner, "label", "pre", "post", "receptor", "synapse_type")
        copy_mappings(self, owner, "synapse_parameters", "plasticity", "initial_values")
        for name in ("weight", "delay_ms"):
            object.__setattr__(
                self, name, require_values(f"{owner}: its {name}", freeze_value(stored_form(self, name)))
            )
        sources, targets = len(indices_of(self, "pre_index")), len(indices_of(self, "post_index"))
        if sources != targets:
            raise NetworkError(
                f"{owner}: pre_index has {sources} values and post_index {targets}; they must be as many"
            )

    @property
    def size(self) -> int:
        """Number of synapses."""
        return len(indices_of(self, "pre_index"))

    @property
    def is_plastic(self) -> bool:
        """Whether its weights change by themselves."""
        if self.equations is not None:
            return self.equations.model.is_plastic
        return self.synapse_type in PLASTIC

    @property
    def is_continuous(self) -> bool:
        """Whether its synapses transmit voltages instead of spikes."""
        return self.synapse_type in CONTINUOUS

    @property
    def is_electrical(self) -> bool:
        """Whether its synapses are gap junctions, through which current flows both ways, at no receptor."""
        return self.synapse_type == ELECTRICAL

    @property
    def is_excitatory(self) -> bool:
        """Whether its receptor is not one that inhibits."""
        return self.receptor not in INHIBITORY

    def pairs(self) -> Iterator[tuple[IndexArray, IndexArray]]:
        """Yield ``pre_index`` and ``post_index`` of all synapses in small parts."""
        return zip(indices_of(self, "pre_index").parts(), indices_of(self, "post_index").parts(), strict=True)

    @checks_arguments()
    def ends(self, synapse: int) -> tuple[int, int]:
        """Return the indices of the two cells that a synapse connects."""
        return ends_of(self, synapse)

    @checks_arguments()
    def only(self, synapses: BoolArray | IntArray) -> Projection:
        """Return the projection with only some synapses: a mask, or their places in a new order."""
        return replace(
            self,
            pre_index=self.pre_index[synapses],
            post_index=self.post_index[synapses],
            weight=_chosen(self.weight, synapses),
            delay_ms=_chosen(self.delay_ms, synapses),
            synapse_parameters={
                name: _chosen(values, synapses) for name, values in self.synapse_parameters.items()
            },
            initial_values={name: _chosen(values, synapses) for name, values in self.initial_values.items()},
            origin=LISTED,
        )


@dataclass(frozen=True, repr=False)
class Network(Overview):
    """Populations, the projections between them, and named views of their neurons.

    Args:
        populations: by label, in definition order (which fixes the global ids).
        projections: in definition order.
        views: named groups of neurons as global ids, ``nrp.brain.<name>`` in transfer functions.
        timestep_ms: the time step that the model was written for, or None if it names none; a
            backend with a fixed time step may use it.
        remarks: sentences about differences between the script and the network; not part of its identity.
        currents: currents that flow into cells at given times.

    Raises:
        NetworkError: the network is inconsistent.
    """

    populations: Mapping[str, Population]
    projections: tuple[Projection, ...] = ()
    views: Mapping[str, IntArray] = field(default_factory=dict)
    timestep_ms: float | None = None
    remarks: tuple[str, ...] = field(default=(), compare=False, kw_only=True)
    currents: tuple[InjectedCurrent, ...] = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        copy_mappings(self, "network", "populations", "views")
        object.__setattr__(self, "views", {name: global_ids(name, ids) for name, ids in self.views.items()})
        copy_mappings(self, "network", "views")
        if not isinstance(self.projections, Iterable):
            raise NetworkError(f"the projections of a network are a sequence, not {self.projections!r:.60}")
        object.__setattr__(self, "projections", tuple(self.projections))  # an iterator would end here
        require_parts("populations", Population, self.populations.values())
        require_parts("projections", Projection, self.projections)
        require_parts("currents", InjectedCurrent, self.currents)
        for current in self.currents:
            require_targets(current, self.populations)
        require_timestep(self.timestep_ms)
        for label, population in self.populations.items():
            if label != population.label:
                raise NetworkError(f"population '{population.label}' is stored under the name '{label}'")
            if population.equations is None:
                names = population.parameters, population.initial_values
                require_cell_names(label, population.cell_type, *names)
                check_cells(f"population '{label}'", population.parameters)
        require_own_labels(projection.label for projection in self.projections)
        for projection in self.projections:
            self._check(projection)
        for name, ids in self.views.items():
            if ids.size and not (ids.min() >= 0 and ids.max() < self.size):
                raise NetworkError(f"view '{name}' reaches outside the network's {self.size} neurons")

    def _overview(self) -> tuple[str, Iterable[Row]]:
        n_synapses = sum(projection.size for projection in self.projections)
        return (
            f"of {self.size} cells in {counted(len(self.populations), 'population')}, "
            f"with {n_synapses} synapses in {counted(len(self.projections), 'projection')}",
            [
                ("population or projection", "cells or synapses", "kind"),
                *((one.label, one.size, one.cell_type) for one in self.populations.values()),
                *((one.label, one.size, one.synapse_type) for one in self.projections),
            ],
        )

    @cached_property
    def size(self) -> int:
        """Number of neurons, sources included."""
        return sum(population.size for population in self.populations.values())

    @cached_property
    def offsets(self) -> Mapping[str, int]:
        """Global id of the first neuron of each population."""
        offsets, total = {}, 0
        for label, population in self.populations.items():
            offsets[label] = total
            total += population.size
        return offsets

    @checks_arguments()
    def neurons(self, label: str) -> IntArray:
        """Return the global ids of a named view or population.

        Raises:
            NeuronSelectionError: no view or population has that name.
        """
        if label in self.views:
            return self.views[label]
        if label not in self.populations:
            hint = did_you_mean(label, [*self.views, *self.populations])
            raise NeuronSelectionError(f"the brain has no population '{label}'{hint}", instead=hint.instead)
        return self.ids_of(label)

    def ids_of(self, label: str) -> IntArray:
        """Return the global ids of a population.

        Raises:
            NeuronSelectionError: no population has this name.
        """
        if label not in self.populations:
            known = did_you_mean(label, self.populations)
            raise NeuronSelectionError(f"the network has no population '{label}'{known}")
        first = self.offsets[label]
        return np.arange(first, first + self.populations[label].size)

    @checks_arguments()
    def label_of(self, neuron: int) -> tuple[str, int]:
        """Return the population of a global id and the index within it."""
        for label, first in self.offsets.items():
            if first <= neuron < first + self.populations[label].size:
                return label, neuron - first
        raise NeuronSelectionError(f"the network has no neuron {neuron}; it has {self.size}")

    @checks_arguments()
    def positions_of(self, neurons: IntArray) -> FloatArray:
        """Return the positions of neurons (global ids), um, shape ``(n, 3)``.

        Raises:
            NeuronSelectionError: a population of these neurons has no positions.
        """
        positions = np.empty((len(neurons), 3))
        for label, population in self.populations.items():
            index = neurons - self.offsets[label]
            mine = (index >= 0) & (index < population.size)
            if mine.any():
                if population.positions_um is None:
                    raise NeuronSelectionError(
                        f"population '{label}' has no positions; give it a structure where it is made, "
                        "e.g. sim.Population(10, ..., structure=sim.Line(dx=50.0))"
                    )
                positions[mine] = population.positions_um[index[mine]]
        return positions

    def synaptic_times_ms(self, neurons: IntArray, receptor: str) -> FloatArray:
        """Return the time constant of a receptor of each neuron (global ids); 0 for delta synapses."""
        times, name = np.zeros(self.size), "tau_syn_E" if receptor == "excitatory" else "tau_syn_I"
        for label, population in self.populations.items():
            if name in population.parameters:
                times[self.ids_of(label)] = population.parameters[name]
        return times[neurons]

    def require_complete(self) -> None:
        """Check that all parameters are given that simulators read; a description of a network has only some.

        Raises:
            NetworkError: one is missing.
        """
        for one in self.populations.values():
            if one.equations is None and one.cell_type in CELLS:
                owner = f"population '{one.label}' ({one.cell_type})"
                require_all_parameters(owner, one.parameters, CELLS[one.cell_type].parameters)
        for each in self.projections:
            law = LAWS.get(each.synapse_type)
            if law is not None and not law.parts:  # a part that is not chosen needs none
                owner = f"projection '{each.label}' ({each.synapse_type})"
                require_all_parameters(owner, each.synapse_parameters, law.parameters)

    @cached_property
    def digest(self) -> str:
        """Hash of everything in the network; equal digests, equal networks."""
        state = hashlib.blake2b(digest_size=16)
        for population in self.populations.values():
            feed(state, (population.label, population.size, population.cell_type))
            feed(state, dict(population.parameters), dict(population.initial_values))
            feed(state, population.spike_times_ms, population.positions_um)
            if population.hints:  # a population without them has the digest that it always had
                feed(state, dict(population.hints))
            if population.equations is not None:
                feed(state, population.equations.data())
        for projection in self.projections:
            feed(state, (projection.label, projection.pre, projection.post, projection.receptor))
            for name in ("pre_index", "post_index"):
                state.update(f"int32{(projection.size,)}False".encode())  # broadcast, as in feed
                for part in indices_of(projection, name).parts():
                    state.update(part.tobytes())
            feed(state, projection.weight, projection.delay_ms, projection.synapse_type)
            feed(state, dict(projection.synapse_parameters), dict(projection.plasticity))
            feed(state, asdict(projection.origin))
            if projection.equations is not None:
                feed(state, projection.equations.data())
            if projection.initial_values:
                feed(state, dict(projection.initial_values))
            feed(state, *_changes_of(projection))
        feed(state, dict(self.views), self.timestep_ms)
        for current in self.currents:
            feed(state, current.neurons, current.times_ms, current.amplitudes_na)
        return state.hexdigest()

    def _check(self, projection: Projection) -> None:
        where = f"projection '{projection.label}'"
        for end in ("pre", "post"):
            label = getattr(projection, end)
            if label not in self.populations:
                raise NetworkError(f"{where} names no population '{label}'")
            size = self.populations[label].size
            lowest, highest = indices_of(projection, f"{end}_index").bounds()
            if lowest < 0 or highest >= size:
                raise NetworkError(
                    f"{where}: {end}_index reaches outside population '{label}' of {size} cells"
                )
        self._check_receptor(where, projection)
        if self.populations[projection.post].is_source:
            raise NetworkError(f"{where} ends on '{projection.post}', which only emits spikes")
        if projection.is_continuous:
            require_voltages(where, projection, self.populations)
        if projection.equations is None:
            require_synapse_names(projection.label, projection.synapse_type, projection.synapse_parameters)
        self._check_values(where, projection)

    def _check_receptor(self, where: str, projection: Projection) -> None:
        equations = self.populations[projection.post].equations
        valid = RECEPTORS
        if projection.neuromodulation is not None:
            equations, valid = None, MODULATORY
        if projection.is_electrical:  # acts on the membrane itself
            equations = None
        if equations is None and projection.receptor not in valid:
            raise NetworkError(
                f"{where}: receptor '{projection.receptor}'{did_you_mean(projection.receptor, valid)}"
            )
        if (
            equations is not None
            and valid is RECEPTORS
            and projection.receptor not in equations.model.receptors
        ):
            known = equations.model.receptors
            raise NetworkError(
                f"{where}: the equations of '{projection.post}' have no receptor '{projection.receptor}'"
                f"{did_you_mean(projection.receptor, known) if known else '; give `receptors`'}"
            )

    def _check_values(self, where: str, projection: Projection) -> None:
        values = {"weight": stored_form(projection, "weight"), "delay": stored_form(projection, "delay_ms")}
        for name, array in values.items():
            if array.shape != (projection.size,):
                raise NetworkError(f"{where}: {name} has shape {array.shape}, not ({projection.size},)")
        _check_beginning(where, projection)
        post = self.populations[projection.post]
        conductance_based = post.is_conductance_based or projection.is_electrical
        check_synapses(
            where, projection.ends, {**values, **projection.synapse_parameters},
            receptor=projection.receptor, conductance_based=conductance_based, signed=conductance_based,
            limits=limits_of_synapses(projection.equations),
        )  # fmt: skip
        if projection.equations is not None:
            unit = post.weight_unit(projection.receptor)
            projection.equations.require_weight_unit(where, unit)
            projection.equations.require_values(
                where, describing(projection.ends), projection.synapse_parameters
            )


def _chosen(values: FloatArray, synapses: BoolArray | IntArray) -> FloatArray:
    """Return the values of some synapses; one for all stays one in memory."""
    if values.strides == (0,):
        n = np.count_nonzero(synapses) if synapses.dtype == bool else len(synapses)
        return np.broadcast_to(values[0], int(n))
    return values[synapses]


def _changes_of(projection: Projection) -> list[dict[str, Any]]:
    """Return, as data, the mechanisms other than their law that change the synapses of a projection."""
    both = (projection.rewiring, projection.neuromodulation)
    return [one.data() for one in both if one is not None]


def _check_beginning(where: str, projection: Projection) -> None:
    """Check the state of synapses at time 0."""
    law = LAWS.get(projection.synapse_type)
    known = {} if law is None or law.plastic else law.state
    for name, array in projection.initial_values.items():
        if name not in known:
            hint = did_you_mean(name, known) if known else ""
            raise NetworkError(f"{where}: {projection.synapse_type} synapses have no state '{name}'{hint}")
        limit = known[name].limit
        if array.shape != (projection.size,) or not limit.allows(array).all():
            raise NetworkError(
                f"{where}: its initial {name} must be one number for each synapse, {limit.rule}"
            )
    if law is not None:
        law.require_shares(where, projection.initial_values)
