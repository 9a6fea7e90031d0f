"""Execute a script of PyNEST up to its first ``Simulate``."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any, Final

import numpy as np
from nrp_core.brain import IntArray
from nrp_core.errors import NetworkError
from nrp_core.scripts import Scope
from nrp_core.seeds import Seeds

from nrp_brain_nest.kernel import import_nest

_RUNS: Final = ("Simulate", "Prepare", "Run")


@dataclass(frozen=True)
class Built:
    """What a script had built when it called ``Simulate``.

    Args:
        nest: the module.
        nodes: NEST's ids of the neurons of each population, by the names of variables; shape ``(size,)``.
        views: global ids of neurons that other variables hold, by their names.
        is_conductance: whether a population has neurons whose weights are conductances.
    """

    nest: Any
    nodes: Mapping[str, IntArray]
    views: Mapping[str, IntArray]
    is_conductance: Mapping[str, bool]


class _BuildingEnds(BaseException):
    """Ends the script at its first ``Simulate``."""

    def __init__(self) -> None:
        self.variables: dict[str, Any] = {}


def execute(path: Path, seed: int) -> Built:
    """Execute a script in an empty kernel up to its first ``Simulate``.

    Args:
        path: the script.
        seed: the seed of the brain, from which NEST's follows.

    Raises:
        NetworkError: the script raises, or ends without ``Simulate``; with file and line.
    """
    nest = import_nest()
    nest.ResetKernel()
    nest.verbosity = nest.VerbosityLevel.ERROR
    nest.rng_seed = 1 + Seeds(seed).integer("nest") % (2**32 - 1)
    scope, module = Scope((), lambda _: None), ModuleType(path.stem)
    arguments, sys.argv = sys.argv, [str(path)]
    try:
        with _first_run(nest):
            scope.run(path, module, name="__main__")
    except _BuildingEnds as end:
        return _built(nest, end.variables)
    except (Exception, SystemExit) as error:
        raise scope.located(error, NetworkError, path) from error
    finally:
        sys.argv = arguments
    raise NetworkError(
        "the script ends without Simulate(), which ends the building of its network", path=path
    )


@contextmanager
def _first_run(nest: Any) -> Iterator[None]:
    """Let the first call that runs NEST end the block."""
    originals = {name: getattr(nest, name) for name in _RUNS}

    def end(*_: Any, **__: Any) -> None:
        ending, frames = _BuildingEnds(), []
        frame: FrameType | None = sys._getframe(1)
        while frame is not None:
            frames.append(frame)
            frame = None if frame.f_code.co_name == "<module>" else frame.f_back
        for one in reversed(frames):
            ending.variables |= one.f_locals
            if hasattr(one.f_locals.get("self"), "__dict__"):
                ending.variables |= vars(one.f_locals["self"])
        raise ending

    vars(nest).update(dict.fromkeys(_RUNS, end))  # NEST refuses setattr
    try:
        yield
    finally:
        vars(nest).update(originals)


def _built(nest: Any, variables: Mapping[str, Any]) -> Built:
    """Return the neurons of all variables: the first that holds a neuron gives its population the name."""
    nodes: dict[str, IntArray] = {}
    others: dict[str, IntArray] = {}
    place: dict[int, int] = {}
    for name, ids in _collections(nest, variables):
        own = np.array([one for one in ids.tolist() if one not in place], np.int64)
        if len(own) == len(ids) or (len(own) and name not in nodes):
            label = name if len(own) == len(ids) else f"{name}_rest"
            nodes[label] = own
            place |= {one: len(place) + i for i, one in enumerate(own.tolist())}
        if len(own) < len(ids):
            others[name] = ids
    views = {name: np.array([place[one] for one in ids.tolist()]) for name, ids in others.items()}
    models = {label: np.unique(values_of(nest, ids, "model")) for label, ids in nodes.items()}
    is_conductance = {label: any("cond" in one for one in found) for label, found in models.items()}
    return Built(nest, nodes, views, is_conductance)


def _collections(nest: Any, variables: Mapping[str, Any]) -> Iterator[tuple[str, IntArray]]:
    """Yield the neurons in variables, and in members of lists and dictionaries, by name."""
    for name, value in variables.items():
        members: Iterator[tuple[str, Any]] = iter([(name, value)])
        if isinstance(value, list | tuple):
            members = ((f"{name}_{i}", one) for i, one in enumerate(value))
        elif isinstance(value, dict):
            members = ((f"{name}_{key}", one) for key, one in value.items())
        for label, one in members:
            if isinstance(one, nest.NodeCollection) and len(one):
                ids = np.array(one.tolist(), np.int64)
                ids = ids[values_of(nest, ids, "element_type") == "neuron"]
                if len(ids):
                    yield label, ids


def values_of(nest: Any, ids: IntArray, name: str) -> Any:
    """Return a value of nodes in their order, shape ``(n,)``."""
    order = np.argsort(ids)
    found = np.atleast_1d(nest.NodeCollection(ids[order].tolist()).get(name))
    result = np.empty(len(ids), found.dtype)
    result[order] = found
    return result
