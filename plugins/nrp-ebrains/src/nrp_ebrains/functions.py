"""Preprocessing, transceiver and status functions: their decorators, and how their files are loaded."""

# ruff: noqa: A002, N803 - the names of NRP-core 4
from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from nrp_core.errors import TransferFunctionError, did_you_mean
from nrp_core.scripts import Scope
from nrp_ebrains.datapacks import DataPack, DataPackIdentifier, Identity, RawData
from nrp_ebrains.graph import Node
from nrp_ebrains.modules import registered_by


class Kind(Enum):
    """The kind of a function: when it runs, and what it returns."""

    PREPROCESSING = "preprocessing"
    """Before the others; its datapacks are for them."""
    TRANSCEIVER = "transceiver"
    """Its datapacks are for engines."""
    STATUS = "status"
    """Last; it returns whether the run is done, and a list of data."""


@dataclass
class Function:
    """One function with the requests of its decorators.

    Args:
        kind: its kind.
        engine: the engine with which it runs; empty for a status function.
        call: the function of the file.
        inputs: the datapack of each keyword; a list of them is given as a dictionary by name.
        preprocessed: the keywords whose datapacks preprocessing functions make.
        time, iteration: the keywords that get simulated time (ns) and the number of the iteration.
        path: its file.
    """

    kind: Kind
    engine: str
    call: Callable[..., Any]
    inputs: dict[str, Identity | list[Identity]] = field(default_factory=dict)
    preprocessed: set[str] = field(default_factory=set)
    time: str = ""
    iteration: str = ""
    path: Path | None = None

    def requested(self) -> Iterator[Identity]:
        """Yield the datapacks that engines must provide."""
        for keyword, asked in self.inputs.items():
            if keyword not in self.preprocessed:
                yield from asked if isinstance(asked, list) else (asked,)

    def engines_named(self) -> Iterator[str]:
        """Yield the engines that it names."""
        if self.engine:
            yield self.engine
        yield from (one.engine for one in self.requested())

    def arguments(self, find: Callable[[Identity], DataPack], t_ns: int, iteration: int) -> dict[str, Any]:
        """Return the arguments of a call.

        Args:
            find: returns a datapack.
            t_ns: simulated time.
            iteration: number of the iteration, from 0.
        """
        given: dict[str, Any] = {
            keyword: {one.name: find(one).copy() for one in asked}
            if isinstance(asked, list)
            else find(asked).copy()
            for keyword, asked in self.inputs.items()
        }
        if self.time:
            given[self.time] = t_ns
        if self.iteration:
            given[self.iteration] = iteration
        return given


class Decorators:
    """The decorators of function files, which register functions here.

    Attributes:
        registered: the functions so far.
    """

    def __init__(self) -> None:
        self.registered: list[Function] = []

    def names(self) -> Mapping[str, Any]:
        """Return the names that ``from nrp_core import *`` gives a file."""
        return {
            "DataPackIdentifier": DataPackIdentifier,
            "TransceiverFunction": self.transceiver,
            "PreprocessingFunction": self.preprocessing,
            "StatusFunction": self.status,
            "EngineDataPack": _engine_datapack,
            "EngineDataPacks": _engine_datapacks,
            "PreprocessedDataPack": partial(_engine_datapack, isPreprocessed=True),
            "SimulationTime": _simulation_time,
            "SimulationIteration": _simulation_iteration,
        }

    def transceiver(
        self,
        engineName: str,
        isPreprocessing: bool = False,
    ) -> Callable[[Callable[..., Any]], Function]:
        """Register a function that runs with an engine."""
        return self._registering(Kind.PREPROCESSING if isPreprocessing else Kind.TRANSCEIVER, engineName)

    def preprocessing(self, engineName: str) -> Callable[[Callable[..., Any]], Function]:
        """Register a function that makes datapacks of an engine for other functions."""
        return self._registering(Kind.PREPROCESSING, engineName)

    def status(self) -> Callable[[Callable[..., Any]], Function]:
        """Register the function that decides whether the run is done."""
        return self._registering(Kind.STATUS, "")

    def _registering(self, kind: Kind, engine: str) -> Callable[[Callable[..., Any]], Function]:
        def register(call: Callable[..., Any]) -> Function:
            function = Function(kind, engine, call)
            self.registered.append(function)
            return function

        return register


def _on_function(change: Callable[[Function], None]) -> Callable[[Function], Function]:
    def decorate(function: Function) -> Function:
        if not isinstance(function, Function):
            raise TransferFunctionError(
                "the decorator next to 'def' must be TransceiverFunction, PreprocessingFunction or "
                "StatusFunction; inputs stand above it"
            )
        change(function)
        return function

    return decorate


def _ask(
    keyword: str, asked: Identity | list[Identity], is_preprocessed: bool
) -> Callable[[Function], Function]:
    def ask(function: Function) -> None:
        function.inputs[keyword] = asked
        if is_preprocessed:
            function.preprocessed.add(keyword)

    return _on_function(ask)


def _engine_datapack(
    keyword: str, id: DataPackIdentifier, isPreprocessed: bool = False
) -> Callable[[Function], Function]:
    return _ask(keyword, id.identity, isPreprocessed)


def _engine_datapacks(
    keyword: str, datapackNames: Sequence[str], engineName: str, isPreprocessed: bool = False
) -> Callable[[Function], Function]:
    return _ask(keyword, [Identity(name, engineName) for name in datapackNames], isPreprocessed)


def _simulation_time(keyword: str) -> Callable[[Function], Function]:
    return _on_function(lambda function: setattr(function, "time", keyword))


def _simulation_iteration(keyword: str) -> Callable[[Function], Function]:
    return _on_function(lambda function: setattr(function, "iteration", keyword))


def load_function(path: Path, scope: Scope, shared: ModuleType, decorators: Decorators) -> Function:
    """Execute a function file in the module that all of them share, and return its function.

    Raises:
        TransferFunctionError: it raises, or does not register exactly one function.
    """
    found = registered_by(path, scope, shared, decorators.registered)
    if len(found) != 1:
        raise TransferFunctionError(
            f"a file must register exactly one function, and this one registers {len(found)}", path=path
        )
    found[0].path = path
    return found[0]


def require_own_inputs(functions: Sequence[Function]) -> None:
    """Require that preprocessing functions read only datapacks of the engine that they belong to.

    Raises:
        TransferFunctionError: one reads another's.
    """
    for function in functions:
        if function.kind is Kind.PREPROCESSING:
            for one in function.requested():
                if one.engine != function.engine:
                    raise TransferFunctionError(
                        f"a preprocessing function of '{function.engine}' cannot read the datapack "
                        f"'{one.name}' of '{one.engine}'",
                        path=function.path,
                    )


def datapacks_of(function: Function, result: Any) -> list[DataPack]:
    """Return the datapacks that a call returned.

    Raises:
        TransferFunctionError: it returned something else.
    """
    wrong = [one for one in result if not isinstance(one, DataPack)] if isinstance(result, list) else [result]
    if wrong:
        raise TransferFunctionError(
            f"a {function.kind.value} function returns a list of datapacks, not {type(wrong[0]).__name__}; "
            "an empty list for none",
            path=function.path,
        )
    for pack in result if function.kind is Kind.PREPROCESSING else ():
        if pack.engine_name != function.engine:
            raise TransferFunctionError(
                f"a preprocessing function of '{function.engine}' cannot return the datapack '{pack.name}' "
                f"of '{pack.engine_name}'",
                path=function.path,
            )
    return list(result)


def status_of(function: Function, result: Any) -> tuple[bool, list[Any]]:
    """Return whether a status function reports the end of the run, and its data.

    Raises:
        TransferFunctionError: it returned something else.
    """
    if not (isinstance(result, tuple) and len(result) == 2 and isinstance(result[1], list | tuple)):
        raise TransferFunctionError(
            "a status function returns a pair: whether the run is done, and a list of data",
            path=function.path,
        )
    data = [one.data if isinstance(one, RawData | DataPack) else one for one in result[1]]
    return bool(result[0]), data


def require_engines(functions: Sequence[Function | Node], engines: Sequence[str]) -> None:
    """Require that functions name engines that exist.

    Raises:
        TransferFunctionError: one does not.
    """
    for function in functions:
        for name in function.engines_named():
            if name not in engines:
                message = f"there is no engine '{name}'{did_you_mean(name, engines)}"
                raise TransferFunctionError(message, path=function.path)
