"""Loads a brain script: an ordinary PyNN script that is executed to build a network.

Every PyNN simulator that the script imports, including ``nrp_core.pynn``, is the builder of
:mod:`nrp_core.network.pynn`. This holds only for the script and the modules beside it.
"""

from __future__ import annotations

import importlib
import random
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import CodeType, MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.errors import ExperimentError, NetworkError, did_you_mean
from nrp_core.network.data import Network
from nrp_core.network.picking import Selection, with_views
from nrp_core.paths import MissingFileError, existing_file
from nrp_core.scripts import BuildingEnds, Missing, Scope
from nrp_core.seeds import Seeds, require_seed

if TYPE_CHECKING:
    from nrp_core.network.pynn.dialects import Modules


@contextmanager
def seeded_generators(seed: int) -> Iterator[None]:
    """Seed both generators within a block; afterwards they are in the state of before.

    Args:
        seed: an unsigned integer of 32 bits.
    """
    states = random.getstate(), np.random.get_state()  # noqa: NPY002
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    try:
        yield
    finally:
        random.setstate(states[0])
        np.random.set_state(states[1])  # noqa: NPY002


# modules of PyNN that are not simulators
_LIBRARY = frozenset(
    {
        "common", "connectors", "core", "descriptions", "errors", "models", "morphology", "multisim",
        "network", "parameters", "random", "recording", "serialization", "space", "standardmodels", "utility",
    }
)  # fmt: skip
# simulators of earlier PyNN versions
_FORMER_SIMULATORS = frozenset({"brian", "moose", "nemo", "pcsim"})


_NETWORKS: Final = {".nir": "nrp_formats.load_nir", ".nrpnet": "read_network"}
"""What reads files of networks that are not scripts, by their suffix."""


@checks_arguments("seed", populations=Mapping[str, Any] | None)  # a selection is checked with its circuit
def load_network(
    path: Path | str,
    *,
    populations: Mapping[str, Selection] | None = None,
    seed: int = 0,
    parameters: Mapping[str, object] = MappingProxyType({}),
    simulators: Iterable[str] = (),
    compiled: Callable[[Path], CodeType] | None = None,
    adapt: Callable[[ModuleType], None] | None = None,
    modules: Mapping[str, ModuleType] | None = None,
    other: Callable[[Mapping[str, Any]], Network | None] | None = None,
    missing: Missing | None = None,
    folders: Iterable[Path] = (),
) -> Network:
    """Execute a brain script and return its network.

    Each variable that holds a population, view or assembly becomes a view of that name. A script may also
    make the network as data: a variable ``network`` that holds a :class:`~nrp_core.Network`.

    Args:
        path: the script.
        populations: names for neurons of the script's ``circuit``, a population, view or assembly. A
            ``circuit`` that is a dictionary names its populations by its keys instead.
        seed: the seed of all random numbers that the script does not seed itself, those of ``random`` and
            ``numpy.random`` included.
        parameters: values of the parameters that the script declares; others have their defaults.
        simulators: further modules, ``package.module``, that the script imports as its simulator.
        compiled: returns the code of the script or of a file that it imports, if it is not plain Python.
        adapt: changes the simulator before the script runs, e.g. to add the names of another version.
        modules: further modules for the script, by name.
        other: returns the network that the script built with one of these modules, from its variables, or
            None if it used PyNN.
        missing: returns a placeholder for modules that do not exist.
        folders: further folders to search for the script's modules.

    Raises:
        NetworkError: the script is missing, is not Python, raises, or builds an invalid network; with
            file and line.
        NeuronSelectionError: ``populations`` reaches outside the circuit.
        CapabilityError: the script uses an unsupported model.
        ExperimentError: the seed is not an integer.
    """
    from nrp_core.network.pynn import builder
    from nrp_core.network.pynn.dialects import Dialects
    from nrp_core.network.pynn.export import network_of, views_of

    try:
        file = existing_file(path)
    except MissingFileError as error:
        raise NetworkError(str(error)) from None
    if file.suffix in _NETWORKS:
        raise NetworkError(
            f"this is a network, not a script: read it with {_NETWORKS[file.suffix]}; in an experiment, "
            "'brain.model' names it like a script",
            path=file,
        )
    sim = builder(require_seed(seed), parameters)
    if adapt is not None:
        adapt(sim)
    dialects = Dialects(sim)
    scope = scope_of(sim, simulators, modules or {}, folders, missing, compiled, dialects)
    module = ModuleType(file.stem, None)
    given, sys.argv = sys.argv, [str(file)]  # those of the command that runs the experiment are not for it
    try:
        with suppress(BuildingEnds), seeded_generators(Seeds(seed).integer("script")):
            scope.run(file, module)
    except (Exception, SystemExit) as error:
        raise scope.located(error, NetworkError, file) from error
    finally:
        sys.argv = given
    try:
        network = (other or dialects.network)(vars(module))
        network = network or _made_as_data(vars(module), len(sim.state.populations))
        if network is not None:
            return with_views(network, populations or {})
        _warn_of_lines_without_effect(sim, vars(module))
        return network_of(sim.state, views_of(vars(module), populations or {}, sim.state))
    except ExperimentError as error:
        error.path = error.path or file
        raise


def _warn_of_lines_without_effect(sim: ModuleType, variables: Mapping[str, Any]) -> None:
    """Warn of files that are not written, networks that are not used, and values of no parameter."""
    state = sim.state
    for population, _, file in state.write_on_end:
        state.remark(f"the data of '{population.label}' are not written to '{file}': the script only builds")
    for name, value in variables.items():
        if isinstance(value, Network):
            state.remark(f"the network '{name}' has no effect: that of a script is called 'network'")
    given = vars(sim)["parameter"].__self__
    for name in given.unused:
        hint = did_you_mean(name, given.declared) if given.declared else ""
        state.remark(f"the script declares no parameter '{name}', so its value has no effect{hint}")


def _made_as_data(variables: Mapping[str, Any], populations: int) -> Network | None:
    """Return the network that a script made as data, or None if it used PyNN.

    Raises:
        NetworkError: it made one in both ways.
    """
    network = variables.get("network")
    if not isinstance(network, Network):
        return None
    if populations:
        raise NetworkError(
            f"the script has a 'network' and {populations} populations of PyNN; it must have one of both"
        )
    return network


def scope_of(
    sim: ModuleType,
    simulators: Iterable[str] = (),
    modules: Mapping[str, ModuleType] = MappingProxyType({}),
    folders: Iterable[Path] = (),
    missing: Missing | None = None,
    compiled: Callable[[Path], CodeType] | None = None,
    dialect: Modules | None = None,
    replaced: Callable[[str], object] = str,
) -> Scope:
    """Return a scope in which every PyNN simulator is ``sim``, and PyNN's library uses ``sim``'s classes.

    Args:
        sim: the simulator.
        simulators: dotted names of further modules that are this simulator.
        modules: further modules, by name.
        folders: further folders to search for modules.
        missing: returns a placeholder for modules that do not exist.
        compiled: returns the code of a file; by default it is Python.
        dialect: the modules of other simulators, by default those of all installed dialects over ``sim``.
        replaced: is called once with the name of each other simulator that is imported.
    """
    from nrp_core.network.pynn.api import SIMULATOR_NAME, overlaid
    from nrp_core.network.pynn.dialects import DIALECTS, Dialects

    others = dialect or Dialects(sim)
    more = {**_with_packages(simulators, sim), **modules}

    @cache
    def substitute(name: str) -> ModuleType | None:
        root, _, rest = name.partition(".")
        child = rest.partition(".")[0]
        if name == sim.__name__:
            return sim
        if name in more:
            return more[name]
        if (found := others.module(name)) is not None:
            return found
        if root != "pyNN" or not child:
            return None
        if child in _LIBRARY:
            return overlaid(importlib.import_module(name), others.library_names) if find_spec(name) else None
        if child != SIMULATOR_NAME and not _is_simulator(child):
            return None
        if child != SIMULATOR_NAME:
            replaced(f"pyNN.{child}")
        return sim

    return Scope(
        {"pyNN", "nrp_core", *(name.partition(".")[0] for name in (*DIALECTS.names(), *more))},
        substitute,
        folders,
        missing or others.missing,
        compiled,
    )


def _with_packages(simulators: Iterable[str], sim: ModuleType) -> dict[str, ModuleType]:
    """Return modules that are a simulator, by their dotted names, and the packages that they are in."""
    more = dict.fromkeys(simulators, sim)
    for name in list(more):
        parent, dot, child = name.rpartition(".")
        if dot:
            setattr(more.setdefault(parent, ModuleType(parent)), child, sim)
    return more


def _is_simulator(name: str) -> bool:
    return name in _FORMER_SIMULATORS or find_spec(f"pyNN.{name}") is not None
