"""Read brain files, scripts and HDF5 of 2014, with the populations that experiments name."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, NoReturn

import numpy as np
from nrp_pynest.api import nest_module
from nrp_pynest.built import BuiltBrain
from nrp_pynest.joining import join
from nrp_pynest.kernel import Kernel, random_of
from nrp_pynest.models import CELLS, SPIKE_RECORDERS, PyNNCells, valid_recovery_ms
from nrp_pynest.network import Conversion, network_of
from nrp_pynest.running import RunningKernel
from pyNN.standardmodels.cells import EIF_cond_alpha_isfa_ista

from nrp_core.brain import (
    ACSource,
    Brain,
    DCSource,
    FloatArray,
    IntArray,
    Network,
    NoisyCurrentSource,
    Population,
    Projection,
    SourceSpec,
)
from nrp_core.dsl import Selector
from nrp_core.errors import ExperimentError, NetworkError, UnreadableError
from nrp_core.findings import Code, Finding
from nrp_core.network.files.hdf5 import array, reading
from nrp_core.network.files.script import load_network
from nrp_core.network.picking import CIRCUIT, Selection, with_views
from nrp_core.network.synapses import TSODYKS_MARKRAM
from nrp_core.scripts import last_name
from nrp_core.xml import Element
from nrp_legacy.code import Notes, Source, compiled_file, defined, ignore_note, without_deprecation_warnings
from nrp_legacy.documents import attribute, children, local, number
from nrp_legacy.files import Library
from nrp_legacy.live.contents import Contents
from nrp_legacy.pynn07 import add_spellings
from nrp_legacy.shims.graph import ClientLogger, Graph, log_modules
from nrp_legacy.shims.libraries import futurized_modules, old_libraries
from nrp_legacy.shims.modules import StandIns, message_modules, module
from nrp_legacy.shims.paths import ImportPath, Paths

CELL = "aeif_cond_alpha"
LABEL = "circuit"
_TIMES_MS = {"tau_syn_E": 1.8, "tau_syn_I": 8.0}
"""Time constants of synapses where the file has none."""
_EXCITES = 100


def read_h5_brain(path: Path) -> Network:
    """Return the network of a file.

    Raises:
        NetworkError: it is not such a file.
    """
    with reading(path) as file:
        size = len(array(file, "x"))
        cells = _cells(file, size)
        excites = array(file, "excitatory") > _EXCITES
        projections = [
            projection
            for receptor, chosen in (("excitatory", excites), ("inhibitory", ~excites))
            if (projection := _projection(file, receptor, np.flatnonzero(chosen))) is not None
        ]
    return Network({LABEL: cells}, tuple(projections), {LABEL: np.arange(size)}, timestep_ms=0.1)


def _cells(file: Any, size: int) -> Population:
    parameters: dict[str, FloatArray] = {}
    for name, default in EIF_cond_alpha_isfa_ista.default_parameters.items():
        source = CELLS[CELL].parameters.get(name)
        if name in _TIMES_MS:
            values = array(file, name, float) if name in file else np.full(size, _TIMES_MS[name])
        elif name == "tau_m":
            values = array(file, "C_m", float) / array(file, "g_L", float)
        elif source is not None and source.name in file:
            values = array(file, source.name, float) * source.scale
        else:
            values = np.full(size, float(default))
        parameters[name] = np.ascontiguousarray(values)
    positions = np.stack([array(file, axis, float) for axis in "xyz"], axis=1)
    initial = {"v": parameters["v_rest"].copy()}
    initial |= {
        name: np.full(size, float(value))
        for name, value in EIF_cond_alpha_isfa_ista.default_initial_values.items()
        if name != "v"
    }
    cell_type = CELLS[CELL].cell_type
    return Population(LABEL, size, cell_type, parameters, initial, positions_um=positions)


def _projection(file: Any, receptor: str, sources: np.ndarray[Any, Any]) -> Projection | None:
    tables = {i: array(file, f"syn_{i + 1}", float) for i in sources.tolist() if f"syn_{i + 1}" in file}
    if not tables:
        return None
    rows = np.concatenate([table[:6] for table in tables.values()], axis=1)
    pre = np.repeat(list(tables), [table.shape[1] for table in tables.values()])
    target, delay, weight, u, recovery, facilitation = rows
    return Projection(
        receptor, LABEL, LABEL, receptor, pre.astype(np.int32), target.astype(np.int32) - 1,
        np.abs(weight) * 1e-3, delay, TSODYKS_MARKRAM,
        {"U": u, "tau_rec": valid_recovery_ms(recovery), "tau_facil": facilitation},
    )  # fmt: skip


EXTERNAL_DEVICES = (
    "spynnaker_external_devices_plugin.pyNN", "spynnaker8.external_devices",
    "spynnaker.pyNN.external_devices", "pyNN.spiNNaker.external_devices",
)  # fmt: skip
"""Modules of the devices."""
_SETTINGS = ("set_number_of_neurons_per_core", "add_machine_constraint", "set_allow_delay_extensions")


def external_devices(sim: ModuleType) -> ModuleType:
    """Return the live devices for spikes to and from the machine, which the experiment replaces."""

    class LiveSpikesConnection:
        def __init__(self, *_values: Any, **_options: Any) -> None:
            """Connect nothing."""

        def _nothing(self, *_values: Any, **_options: Any) -> None:
            """Do nothing."""

        add_receive_callback = add_start_callback = add_start_resume_callback = add_init_callback = _nothing
        send_spike = send_spikes = add_pause_stop_callback = start = join = close = _nothing

    return module(
        "external_devices",
        activate_live_output_for=_set_nothing, activate_live_output_to=_set_nothing,
        SpikeInjector=lambda *_values, **_options: sim.SpikeSourceArray(spike_times=[]),
        SpynnakerLiveSpikesConnection=LiveSpikesConnection,
        SpynnakerPoissonControlConnection=LiveSpikesConnection,
    )  # fmt: skip


def add_spinnaker(sim: ModuleType) -> None:
    """Add the functions of simulators for SpiNNaker to a simulator."""
    vars(sim).update(dict.fromkeys(_SETTINGS, _set_nothing), external_devices=external_devices(sim))


def _set_nothing(*_values: Any, **_options: Any) -> None:
    """Do nothing, because no machine is used."""


_FOREVER_MS = 1e12


@dataclass(frozen=True)
class Injection:
    """A current into cells (global ids)."""

    spec: SourceSpec
    cells: IntArray


def collect_injections(sim: ModuleType) -> list[Injection]:
    """Add time-dependent currents to a simulator; return the list that collects them."""
    kept: list[Injection] = []
    sources: list[Any] = []
    state, constant, injected = sim.state, sim.state.inject, sim.state.injected

    def inject(source: Any, cells: IntArray) -> None:
        if type(source).__name__ == "DCSource" and source.start <= 0.0 and source.stop >= _FOREVER_MS:
            constant(source, cells)
        else:
            sources.append(source)
            kept.extend(Injection(spec, cells) for spec in _specs(source))

    state.inject, state.injected = inject, lambda: [*injected(), *sources]
    return kept


def inject_currents(injections: tuple[Injection, ...], brain: Brain) -> None:
    """Add currents to a brain."""
    for i, injection in enumerate(injections):
        brain.add_source(injection.spec, injection.cells, name=f"brain/current/{i}")


def _specs(source: Any) -> Iterator[SourceSpec]:
    kind = type(source).__name__
    if kind == "StepCurrentSource":
        ends = np.append(source.times[1:], inf)
        for start, stop, amplitude in zip(source.times, ends, source.amplitudes, strict=True):
            yield DCSource(start=float(start), stop=float(stop), amplitude=float(amplitude))
        return
    start, stop = float(source.start), inf if source.stop >= _FOREVER_MS else float(source.stop)
    if kind == "DCSource":
        yield DCSource(start=start, stop=stop, amplitude=source.amplitude)
    elif kind == "ACSource":
        wave = {name: getattr(source, name) for name in ("amplitude", "offset", "frequency", "phase")}
        yield ACSource(start=start, stop=stop, **wave)
    elif kind == "NoisyCurrentSource":
        yield NoisyCurrentSource(start=start, stop=stop, mean=source.mean, stdev=source.stdev)


_PYNN = ("pyNN", "hbp_nrp_cle.brainsim", "python_cle", "spynnaker")
"""How the names of modules begin in which scripts find PyNN's populations."""
_PLACES = ("from", "to", "step", "index")
_HDF5 = (".h5", ".hdf5")
_SIMULATORS = (
    "hbp_nrp_cle.brainsim.simulator", "hbp_nrp_cle.brainsim.pynn.simulator", "python_cle.brainsim.simulator",
    "pyNN.spiNNaker", "spynnaker.pyNN", "spynnaker7.pyNN", "spynnaker8", "pyNN.hardware",
)  # fmt: skip


@dataclass(frozen=True)
class NotedNetwork(Network):
    """A network with notes for users.

    Args:
        notes: remarks for the user.
        injections: currents that its file injects.
        built: the variables of its file.
    """

    notes: tuple[Finding, ...] = ()
    injections: tuple[Injection, ...] = ()
    built: BuiltBrain = field(default_factory=BuiltBrain)


def load_brain(
    path: Path,
    populations: Mapping[str, Element],
    seed: int,
    folders: Sequence[Path] = (),
    library: Library | None = None,
    parameters: Mapping[str, object] = MappingProxyType({}),
) -> Network:
    """Return the network of a brain file, with the names that an experiment gives its neurons.

    Args:
        path: a script for PyNN or NEST, or an HDF5 file.
        populations: elements that select neurons of the file's ``circuit``, by population name.
        seed: the seed of every random number.
        folders: the folders whose modules a script can import.
        library: the search path for files that a script names.
        parameters: values of the parameters that a script declares.

    Raises:
        NetworkError: the file cannot be turned into a network.
    """
    if path.suffix in _HDF5:
        network = read_h5_brain(path)
    else:
        network = load_script(path, seed, folders=folders, library=library, parameters=parameters)
    views = dict(network.views)
    for name, chosen in populations.items():
        with suppress(ExperimentError):  # reported as a name without neurons
            ids = _chosen(chosen, name, views)
            if ids is not None and ids.size:
                views[name] = ids
    return replace(network, views=views)


def load_script(
    path: Path,
    seed: int,
    populations: Mapping[str, Selection] | None = None,
    folders: Sequence[Path] = (),
    library: Library | None = None,
    parameters: Mapping[str, object] = MappingProxyType({}),
) -> Network:
    """Return the network of a script for PyNN or NEST.

    Args:
        path: the script.
        seed: the seed of every random number.
        populations: the names of neurons of its ``circuit``.
        folders: the folders whose modules it can import.
        library: the search path for files that it names, by default its folder.
        parameters: values of the parameters that it declares.

    Raises:
        NetworkError: the file cannot be turned into a network.
        NeuronSelectionError: ``populations`` reaches outside the circuit.
    """
    if path.suffix != ".py":
        raise NetworkError(f"a brain must be a .py or .h5 file, not '{path.name}'", path=path)
    built, currents = BuiltBrain(), list[Injection]()
    kernel = RunningKernel(random_of(seed), built, is_lenient=True)
    kernel.is_beside = _makes_populations(path)
    built.nest = nest_module(kernel)
    built.on_begin.append(kernel.begin)
    kept: list[dict[str, Any]] = []
    sims: list[ModuleType] = []

    def by_nest(variables: Mapping[str, Any]) -> Network | None:
        kept.append(variables)  # type: ignore[arg-type] # of a module
        if kernel.beside:
            kernel.joined = join(kernel, sims[0], kept[0])
            kernel.beside = None
        return network_of(kernel, variables) if kernel.groups else None

    def adapt(sim: ModuleType) -> None:
        nonlocal currents
        add_spellings(sim, kernel)
        add_spinnaker(sim)
        modules.update(dict.fromkeys(EXTERNAL_DEVICES, sim.external_devices))
        vars(sim)["nest"] = built.nest
        kernel.beside = PyNNCells(sim)
        sims.append(sim)
        currents = collect_injections(sim)

    files = library or Library(path.parent)
    libraries = old_libraries(
        files.environment(), lambda _seconds: None, seed, built.import_path, Paths(files)
    )
    modules = {
        **message_modules(),
        **libraries,
        "nest": built.nest,
        **futurized_modules(),
        **log_modules(ClientLogger(Graph())),
    }
    with without_deprecation_warnings():
        made = load_network(
            path, seed=seed, parameters=parameters, simulators=_SIMULATORS, compiled=compiled_file,
            adapt=adapt, modules=modules, other=by_nest, missing=StandIns(kernel.notes.add),
            folders=ImportPath(built.import_path, folders, files),
        )  # fmt: skip
    parts = made.populations, made.projections, made.views, made.timestep_ms
    _keep(built, kernel, made, kept[0], sims[0])
    noted = NotedNetwork(*parts, tuple(kernel.notes), tuple(currents), built, remarks=made.remarks)
    return with_views(noted, populations or {})


def _makes_populations(path: Path) -> bool:
    """Return whether a script calls for populations of PyNN."""
    try:
        nodes = list(ast.walk(Source.of_file(path).tree(ignore_note)))
    except ExperimentError:  # it is refused when it runs
        return False
    imported = [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
    imported += [one.name for node in nodes if isinstance(node, ast.Import) for one in node.names]
    called = (node.func for node in nodes if isinstance(node, ast.Call))
    return any(name.startswith(_PYNN) for name in imported) and any(
        last_name(function) == "Population" for function in called
    )


def _keep(
    built: BuiltBrain, kernel: RunningKernel, network: Network, variables: dict[str, Any], sim: ModuleType
) -> None:
    """Connect the variables of a brain file to the brain that will run."""
    made = connect_nest(built, kernel, network)
    contents = Contents(built, made.cells_of)
    contents.replace(variables)
    built.variables, built.show = variables, contents.shown
    recorded = [cells.tolist() for cells in built.recorded] if kernel.groups else _recorded_by_pynn(sim)
    heard = [cells.tolist() for cells in kernel.joined.recorded.values()]
    recorded += [cells for cells in heard if cells not in map(sorted, recorded)]
    built.recorded = [np.array(sorted(cells), dtype=np.int64) for cells in recorded if cells]
    if not kernel.groups:
        built.recorded_states = _states_recorded_by_pynn(sim)


def connect_nest(built: BuiltBrain, kernel: RunningKernel, network: Network) -> Conversion:
    """Connect the nodes of NEST, if any, to the brain that will run.

    Returns:
        the conversion of the nodes.
    """
    made = Conversion(kernel)
    built.network = network
    if kernel.groups:
        nodes = {cell: node for node, cell in made.ids.items()}
        built.node_of = lambda neuron: nodes[neuron]
        recorded = _recorded_by_nest(kernel, made)
        built.recorded = [np.array(sorted(cells), dtype=np.int64) for cells in recorded if cells]
        built.recorded_states = list(kernel.measured(made))
    return made


def _recorded_by_nest(kernel: Kernel, made: Conversion) -> list[list[int]]:
    """Return the cells whose spikes each recorder gets."""
    heard = (kernel.recorded_by(group.first) for group in kernel.groups if group.base in SPIKE_RECORDERS)
    return [[made.ids[node] for node in some.tolist() if node in made.ids] for some in heard]


def _recorded_by_pynn(sim: ModuleType) -> list[list[int]]:
    """Return the cells of each population whose spikes are recorded."""
    recorders = [population.recorder.recorded for population in sim.state.populations]
    return [
        [int(cell) for what, cells in recorded.items() if what.name == "spikes" for cell in cells]
        for recorded in recorders
    ]


def _states_recorded_by_pynn(sim: ModuleType) -> list[tuple[str, IntArray, float | None]]:
    """Return the state variables that are recorded, each with cells of one population."""
    return [
        (what.name, np.array(sorted(map(int, cells)), dtype=np.int64), None)
        for population in sim.state.populations
        for what, cells in population.recorder.recorded.items()
        if what.name != "spikes" and cells
    ]


def with_variables(network: Network, path: Path) -> Network:
    """Return the network of a script with its variables, or only their names if it ran elsewhere.

    Args:
        network: the network that the script has built.
        path: the script.
    """
    if path.suffix != ".py" or isinstance(network, NotedNetwork):
        return network
    built = BuiltBrain()
    names = defined(Source.of_file(path).tree(ignore_note))
    built.variables = {name: Selector(partial(_raise_unreadable, name), f"brain.{name}") for name in names}
    parts = network.populations, network.projections, network.views, network.timestep_ms
    return NotedNetwork(*parts, built=built, remarks=network.remarks, currents=network.currents)


def _raise_unreadable(name: str, _root: object) -> NoReturn:
    raise UnreadableError(f"'{name}' is known only after the brain file has been executed")


def remark(path: Path, populations: Mapping[str, Element], network: Network, notes: Notes) -> None:
    """Report the conversions in a brain file, and names that do not exist in its network."""
    if path.suffix == ".py":
        Source.of_file(path).compiled(notes)
    for note in getattr(network, "notes", ()):
        notes(note.code, f"{path.name}: {note.message}", subject=note.subject)
    circuit = network.views.get(CIRCUIT, ())
    for name, element in populations.items():
        last = _last(element)
        if name not in (*network.views, *network.populations):
            asked = [f"{key}={value}" for key, value in element.attributes.items() if local(key) in _PLACES]
            asked += [f"element {one.text.strip()}" for one in element.children]
            message = f"population '{name}' has no neurons in {path.name}: {', '.join(asked)}".rstrip(": ")
            if not len(circuit) and path.suffix == ".py":
                message += f"; the script has no variable '{CIRCUIT}' with cells, from which they are chosen"
            notes(Code.NRP211, message, subject=name)
        elif len(circuit) and last is not None and last >= len(circuit):
            message = (
                f"population '{name}' goes to neuron {last}, and {path.name} has {len(circuit)}: the others "
                "are left out"
            )
            notes(Code.NRP211, message, subject=name)
        elif (count := number(element, "count")) is not None:
            size = len(network.neurons(name))
            if size != count:
                message = (
                    f"count of the population '{name}' is {count:g}, and {path.name} has {size}: all are used"
                )
                notes(Code.NRP216, message, subject=name)


def _last(element: Element) -> int | None:
    """Return the last neuron that an element names; None if it names none."""
    named = [int(one.text) for one in children(element, "element") if one.text.isdecimal()]
    named += [int(index)] if (index := number(element, "index")) is not None else []
    named += [int(end) - 1] if (end := number(element, "to")) is not None else []
    return max(named, default=None)


def _chosen(element: Element, name: str, views: Mapping[str, IntArray]) -> IntArray | None:
    """Return the neurons that an element selects, None if it only names a population of the file."""
    circuit = views.get(CIRCUIT)
    kind = local(attribute(element, "type") or "")
    if circuit is None:
        return None
    listed = children(element, "element")
    if kind == "List" or listed:
        places = np.array([_index(one) for one in listed], dtype=np.int64)
        return circuit[places[places < len(circuit)]]
    index, begin = number(element, "index"), number(element, "from")
    if index is not None:
        return circuit[int(index) : int(index) + 1]
    if kind == "Range" or begin is not None:
        end, step = number(element, "to"), number(element, "step")
        stride = int(step or 1)
        if not stride:
            raise element.error(f"'step' of <{element.tag}> must be a whole number, not {step:g}")
        return circuit[int(begin or 0) : None if end is None else int(end) : stride]
    return None if name in views else circuit


def _index(element: Element) -> int:
    if not element.text.isdecimal() or len(element.text) > _DIGITS:
        raise element.error(f"<{element.tag}> must be the index of a neuron, not '{element.text}'")
    return int(element.text)


_DIGITS = 18  # what 64 bits hold for certain
