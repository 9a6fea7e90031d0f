"""A script with populations of PyNN and calls of NEST: the nodes and synapses of NEST become PyNN's."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from nrp_core.brain import IntArray
from nrp_core.errors import NetworkError
from nrp_core.network.synapses import STDP, TSODYKS_MARKRAM
from nrp_pynest.kernel import Block, Group, Kernel
from nrp_pynest.models import CELLS, CURRENT, POISSON, SPIKE_RECORDERS, SPIKES, scale_of
from nrp_pynest.network import (
    by_ends,
    by_receptor,
    cells_from,
    nodes_in,
    plasticity_of,
    trains_at,
    trains_of,
    with_two_receptors,
)

_DIRECT = {"amplitude": 0.0, "start": 0.0, "stop": 1e12}


@dataclass
class Joined:
    """The cells that nodes of NEST have become, or record; cells are numbered as in the network.

    Args:
        cells: of nodes that are cells or generators of spikes.
        sources: of Poisson generators, which have one for each synapse.
        recorded: of recorders, ascending.
    """

    cells: dict[int, int] = field(default_factory=dict)
    sources: dict[int, list[int]] = field(default_factory=dict)
    recorded: dict[int, IntArray] = field(default_factory=dict)


def join(kernel: Kernel, sim: ModuleType, variables: dict[str, Any]) -> Joined:
    """Add the objects that calls of NEST made to PyNN's simulator; the kernel is empty afterwards.

    Cells and generators of spikes become populations, and so do Poisson generators, with a source for each
    synapse, as each target gets a train of its own. Generators of direct current become current sources, and
    recorders of spikes record. Variables with nodes become populations or views of them.

    Args:
        kernel: the nodes and synapses.
        sim: the simulator, with populations.
        variables: of the script.

    Raises:
        NetworkError: a node does not exist, or its number is that of a cell of PyNN too.
    """
    joining = _Joining(kernel, sim)
    for block in kernel.blocks:
        joining.connect(block)
    for name, value in list(variables.items()):
        if (found := joining.seen(value)) is not None:
            variables[name] = found
    joined = joining.joined
    for group in kernel.groups:
        for node in range(group.first, group.first + group.size) if group.base in SPIKE_RECORDERS else ():
            cells = [joined.cells.get(one, one) for one in kernel.recorded_by(node).tolist()]
            joined.recorded[node] = np.array(sorted(cells), dtype=np.int64)
    kernel.groups, kernel.blocks = [], []
    return joined


class _Joining:
    def __init__(self, kernel: Kernel, sim: ModuleType) -> None:
        self._sim, self._kernel, self.joined = sim, kernel, Joined()
        self._ends: list[tuple[int, int, Any]] = [
            (int(one.first_id), one.size, one) for one in sim.state.populations
        ]
        if kernel.groups and kernel.groups[0].first < sim.state.n_cells:
            raise NetworkError(
                f"nest.Create('{kernel.groups[0].model}') comes before PyNN's populations are created, so "
                "the same numbers mean nodes and cells: create the populations first"
            )
        for group in kernel.groups:
            made = self._population(group)
            self._ends.append((group.first, group.size, made))
            if not isinstance(made, Group):
                self.joined.cells |= {group.first + i: int(made.first_id) + i for i in range(group.size)}
        self._starts = [first for first, _size, _thing in self._ends]

    def _population(self, group: Group) -> Any:
        """Return the population that a group of nodes becomes; the group itself if it has no cells."""
        sim = self._sim
        if group.base in CELLS:
            two = with_two_receptors(group, self._kernel)
            if two is None:
                raise NetworkError(
                    f"nest: weights of one sign onto '{group.model}' have several time constants; beside "
                    "populations of PyNN cells have one for each sign"
                )
            cells = cells_from(two, group.model, np.zeros(group.size))
            made = sim.Population(
                group.size, getattr(sim, cells.cell_type)(**cells.parameters), label=group.model
            )
            made.initialize(**cells.initial_values)
            return made
        if group.base == SPIKES:
            times = [sim.Sequence(train) for train in trains_of(group, self._kernel.random)]
            return sim.Population(group.size, sim.SpikeSourceArray(spike_times=times), label=group.model)
        return group

    def connect(self, block: Block) -> None:
        """Connect as the synapses of one call do."""
        for nodes in (block.pre, block.post):
            self._places(nodes)
        for source, target, chosen in by_ends(block, self._starts):
            pre = block.pre[chosen] - self._starts[source]
            post = block.post[chosen] - self._starts[target]
            values = {name: column[chosen] for name, column in block.values.items()}
            sender, receiver = self._ends[source][2], self._ends[target][2]
            if isinstance(receiver, Group):
                if receiver.base in SPIKE_RECORDERS and not isinstance(sender, Group):
                    sender[np.unique(pre)].record("spikes")
            elif not isinstance(sender, Group):
                self._project(sender, receiver, pre, post, values, block)
            elif sender.base == POISSON:
                self._project(self._poisson(sender, pre), receiver, np.arange(len(pre)), post, values, block)
            elif sender.base == CURRENT:
                self._inject(sender, receiver, pre, post, values["weight"])

    def _places(self, nodes: IntArray) -> IntArray:
        places: IntArray = np.searchsorted(self._starts, nodes, "right") - 1
        ends = np.array([first + size for first, size, _thing in self._ends])
        for node in nodes[(places < 0) | (nodes >= ends[places])].tolist():
            raise NetworkError(f"nest: node {node} does not exist")
        return places

    def _poisson(self, group: Group, pre: IntArray) -> Any:
        kind = self._sim.SpikeSourcePoisson(**trains_at(group, pre))
        made = self._sim.Population(len(pre), kind, label=group.model)
        for i, place in enumerate(pre.tolist()):
            self.joined.sources.setdefault(group.first + place, []).append(int(made.first_id) + i)
        return made

    def _inject(self, group: Group, cells: Any, pre: IntArray, post: IntArray, weight: Any) -> None:
        columns = [group.column(name, default) for name, default in _DIRECT.items()]
        for i, place, factor in zip(pre.tolist(), post.tolist(), weight.tolist(), strict=True):
            amplitude, start, stop = (float(column[i]) for column in columns)
            source = self._sim.DCSource(amplitude=amplitude * factor * 1e-3, start=start, stop=stop)
            source.inject_into(cells[place : place + 1])

    def _project(
        self, sender: Any, receiver: Any, pre: IntArray, post: IntArray, values: dict[str, Any], block: Block
    ) -> None:
        for receptor, chosen in by_receptor(values["weight"]):
            own = {name: column[chosen] for name, column in values.items()}
            law, columns = self._law(block.base.kind, own, scale_of(receiver))
            weight = own["weight"] * scale_of(receiver)
            columns["weight"] = np.abs(weight) if receiver.conductance_based else weight
            columns["delay"] = own["delay"]
            listed = np.column_stack([pre[chosen], post[chosen], *columns.values()])
            connector = self._sim.FromListConnector(listed, column_names=list(columns))
            self._sim.Projection(sender, receiver, connector, law, receptor_type=receptor)

    def _law(self, kind: str, values: dict[str, Any], scale: float) -> tuple[Any, dict[str, Any]]:
        """Return the synapse type and its parameters for each synapse."""
        sim = self._sim
        kind, parameters, parts = plasticity_of(kind, values, scale)
        if kind == STDP:
            made = {name: getattr(sim, part)() for name, part in parts.items()}
            return sim.STDPMechanism(**made), parameters
        return sim.TsodyksMarkramSynapse() if kind == TSODYKS_MARKRAM else sim.StaticSynapse(), parameters

    def seen(self, value: Any) -> Any:
        """Return the cells for a variable with nodes, None if it has none."""
        nodes = nodes_in(value)
        if not nodes:
            return None
        numbers = np.array([int(node) for node in nodes])
        places = self._places(numbers)
        parts = []
        for place in dict.fromkeys(places.tolist()):
            first, size, thing = self._ends[place]
            chosen = numbers[places == place] - first
            if isinstance(thing, Group):
                return None
            parts.append(thing if len(chosen) == size else thing[chosen])
        return parts[0] if len(parts) == 1 else self._sim.Assembly(*parts)
