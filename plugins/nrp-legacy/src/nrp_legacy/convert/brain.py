"""The brain of an imported experiment: its script if that builds the same network, else the network.

Files and modules that a script uses are copied with it.
"""

from __future__ import annotations

import ast
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from nrp_core import save_network
from nrp_core.brain import IntArray, Network
from nrp_core.errors import ExperimentError, NrpError
from nrp_core.experiment import network_from
from nrp_core.network.picking import CIRCUIT
from nrp_legacy.brains import NotedNetwork, load_script
from nrp_legacy.code import Source, without_deprecation_warnings
from nrp_legacy.convert.python import Edits, Place, modern, reliance

_LONGEST_NAME = 200


def copy_neighbours(texts: Iterable[str], folders: Sequence[Path], target: Path) -> None:
    """Copy the files that code uses, and the files that imported modules use, into a folder.

    Args:
        texts: the code.
        folders: the folders that are searched, in order.
        target: the target folder.
    """
    waiting, known = list(texts), set[str]()
    while waiting:
        for name in _named(waiting.pop()):
            path = next((path for one in folders if (path := one / name).exists()), None)
            if path is not None and links_to_elsewhere(str(path.parent), [path.name]):
                continue
            if path is None or name in known:
                continue
            known.add(name)
            _copy(path, target / name)
            waiting += [Source.of_file(one).text for one in _modules(target / name)]


def links_to_elsewhere(folder: str, names: Iterable[str]) -> set[str]:
    """Return the entries of a folder that copies omit: symbolic links out of it, and compiled code."""
    home = Path(folder).resolve()
    return {
        name for name in names if name == "__pycache__" or not (home / name).resolve().is_relative_to(home)
    }


def _copy(path: Path, target: Path) -> None:
    """Copy a file or folder, modules as Python 3."""
    if path == target:
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        shutil.copytree(path, target, dirs_exist_ok=True, ignore=links_to_elsewhere)
    else:
        shutil.copy(path, target)
    for module in _modules(target):
        with suppress(ExperimentError):
            text, changes = modern(Source.of_file(module))
            if changes:
                module.write_text(text, encoding="utf-8")


def _modules(path: Path) -> list[Path]:
    """Return the files of a module or package; none for data."""
    return sorted(path.rglob("*.py")) if path.is_dir() else [path] if path.suffix == ".py" else []


def _named(text: str) -> Iterator[str]:
    """Yield the files and folders that code may use: modules, packages, and files named in strings."""
    try:
        with without_deprecation_warnings():
            tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return
    for node in ast.walk(tree):
        match node:
            case ast.Import(names):
                yield from (file for alias in names for file in _files(alias.name))
            case ast.ImportFrom(module=str(module), level=0):
                yield from _files(module)
            case ast.Constant(value=str(name)) if 0 < len(name) < _LONGEST_NAME and name.isprintable():
                parts = PurePosixPath(name).parts
                if parts and parts[0] != "/" and ".." not in parts and "." in parts[-1]:
                    yield name


def _files(module: str) -> tuple[str, str]:
    top = module.partition(".")[0]
    return f"{top}.py", top


SCRIPT, NETWORK = "brain.py", "brain.nrpnet"
_SIMULATORS = ("hbp_nrp_cle", "python_cle")


@dataclass(frozen=True, slots=True)
class Brain:
    """The brain of an imported experiment.

    Args:
        section: the section ``brain`` of the experiment file.
        need: the feature of the platform that it needs, empty for none.
        changes: the differences from the original.
    """

    section: dict[str, Any]
    need: str = ""
    changes: tuple[str, ...] = ()


def write_brain(
    path: Path, network: Network, names: list[str], seed: int, folder: Path, beside: Sequence[Path] = ()
) -> Brain:
    """Write the brain into a folder.

    Args:
        path: the file of the brain.
        network: the network that it builds.
        names: the populations that the experiment names.
        seed: the seed of the experiment.
        folder: the target folder.
        beside: further folders whose modules it can import.
    """
    plain = _plain(network)
    if path.suffix == ".py":
        populations = _populations(network, names)
        section = {"model": SCRIPT, **({"populations": populations} if populations else {})}
        need = "injects time-dependent currents into cells" if _flows(network) else ""
        for write, load in _WAYS[bool(need) :]:
            try:
                changes = write(path, folder, (path.parent, *beside))
                if _is_same(load(folder / SCRIPT, seed, populations), plain):
                    return Brain(section, need and f"{path.name}: {need}", changes)
                need = f"builds a different network without the platform's modules{_cause(path)}"
            except (SyntaxError, NrpError) as error:
                line = getattr(error, "line", None) or getattr(error, "lineno", None)
                need = (getattr(error, "message", "") or str(error)) + (
                    f" ({path.name}:{line})" if line else ""
                )
        (folder / SCRIPT).unlink(missing_ok=True)
    save_network(plain, folder / NETWORK, overwrite=True)
    lost = [f"{path.name}: time-dependent currents cannot be part of a network file: left out"]
    written = f"{path.name} was replaced by its network, {NETWORK}"
    return Brain({"model": NETWORK}, "", (*(lost if _flows(network) else ()), written))


def _cause(path: Path) -> str:
    """Return the first use of the platform's modules in a script, empty if none was found."""
    source = Source.of_file(path)
    text, _ = modern(source)
    with without_deprecation_warnings():
        relied, line = reliance(ast.parse(text))
    return f": {relied}{Place(source, text).of(line)}" if relied else ""


def _flows(network: Network) -> bool:
    """Whether its script sends currents that change with time."""
    return isinstance(network, NotedNetwork) and bool(network.injections)


def _as_ours(path: Path, folder: Path, beside: Sequence[Path]) -> tuple[str, ...]:
    text, changes = modern(Source.of_file(path))
    (folder / SCRIPT).write_text(_with_our_simulator(text), encoding="utf-8")
    copy_neighbours([text], beside, folder)
    return tuple(f"{path.name}: {change}" for change in changes)


def _as_it_is(path: Path, folder: Path, beside: Sequence[Path]) -> tuple[str, ...]:
    text, changes = modern(Source.of_file(path))
    (folder / SCRIPT).write_text(text, encoding="utf-8")
    copy_neighbours([text], beside, folder)
    return tuple(f"{path.name}: {change}" for change in changes)


def _load_ours(path: Path, seed: int, populations: dict[str, Any]) -> Network:
    with without_deprecation_warnings():
        return network_from(path, populations=populations, seed=seed)


_WAYS = ((_as_ours, _load_ours), (_as_it_is, load_script))
"""How a script is written and then read: alone, and with the platform's modules."""


def _is_same(own: Network, meant: Network) -> bool:
    if replace(_plain(own), views={}).digest != replace(meant, views={}).digest:
        return False
    return all(_same(own.views, meant.views, name) for name in meant.views)


def _plain(network: Network) -> Network:
    parts = network.populations, network.projections, network.views, network.timestep_ms
    return Network(*parts, currents=network.currents)


def _same(own: Mapping[str, IntArray], meant: Mapping[str, IntArray], name: str) -> bool:
    return name in own and np.array_equal(own[name], meant[name])


def _with_our_simulator(text: str) -> str:
    edits = Edits(text)
    for node in ast.walk(ast.parse(text)):
        names = getattr(node, "names", [])
        if isinstance(node, ast.ImportFrom) and str(node.module).partition(".")[0] in _SIMULATORS:
            edits.replace(node, f"import nrp_core.pynn as {names[0].asname or names[0].name}")
        elif isinstance(node, ast.Import) and names[0].name.partition(".")[0] in _SIMULATORS:
            edits.replace(node, f"import nrp_core.pynn as {names[0].asname or 'sim'}")
    return edits.done()


def _populations(network: Network, names: list[str]) -> dict[str, str | list[int]]:
    """Return the cells of the circuit for the names in an experiment."""
    circuit = network.views.get(CIRCUIT)
    if circuit is None:
        return {}
    place = {int(neuron): i for i, neuron in enumerate(circuit)}
    found = {
        name: [place[int(one)] for one in network.views[name]] for name in names if name in network.views
    }
    return {name: _short(places) for name, places in found.items() if places}


def _short(places: list[int]) -> str | list[int]:
    step = places[1] - places[0] if len(places) > 1 else 1
    if step > 0 and places == list(range(places[0], places[-1] + 1, step)):
        return f"{places[0]}:{places[-1] + 1}" + (f":{step}" if step > 1 else "")
    return places
