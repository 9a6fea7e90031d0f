"""The loop of NRP-core 4 over engines with time steps of their own.

An iteration at time t takes the engines whose steps end at t: it reads their datapacks, runs their
preprocessing and transceiver functions and the status function, sends them the datapacks that are for them,
and starts their next steps. The first iteration is at t = 0, before any step. Of the engines that end
together, those that began earlier come first; at 0 it is the order of the file.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from nrp_core.clock import NS_PER_MS
from nrp_core.errors import ExperimentError, TransferFunctionError, TransferFunctionRaisedError, did_you_mean
from nrp_core.scripts import Scope
from nrp_ebrains.datapacks import DataPack, Identity, copied
from nrp_ebrains.functions import Function, Kind, datapacks_of, status_of
from nrp_ebrains.graph import CLOCK, ITERATION, Graph, Node


class Engine(ABC):
    """One engine of an experiment.

    Args:
        name: its name.
        step_ns: its time step.
    """

    def __init__(self, name: str, step_ns: int) -> None:
        self.name, self.step_ns = name, step_ns

    @abstractmethod
    def initialize(self) -> None:
        """Get ready for time 0."""

    @abstractmethod
    def read(self, names: Iterable[str]) -> Mapping[str, Any]:
        """Return the data of datapacks by name, without unchanged ones.

        Raises:
            ExperimentError: the datapack does not exist.
        """

    @abstractmethod
    def write(self, packs: Sequence[DataPack]) -> None:
        """Take datapacks for the next step."""

    def start_step(self) -> None:
        """Take a step; sides of the run advance with it instead."""

    def reset(self) -> None:
        """Return to time 0."""

    def shutdown(self) -> None:
        """End."""


class Loop:
    """Runs engines and functions.

    Args:
        engines: the engines, in the order of the file.
        functions: the functions, in the order of the file.
        scope: the scope in which the files of the functions were executed.
        nodes: the nodes of a computational graph, which take the place of functions.
        graph_step_ns: the period of the graph in an event loop, which runs all nodes; None: the nodes that an
            engine needs run before its steps.
        is_driven: whether an event loop runs only the nodes that its outputs need.

    Attributes:
        iteration: the number of iterations so far.
        done: whether the status function reported in the last iteration that the run is done.
        trajectory: the data of the status function that has not been taken yet.
    """

    def __init__(
        self,
        engines: Sequence[Engine],
        functions: Sequence[Function],
        scope: Scope,
        nodes: Sequence[Node] = (),
        graph_step_ns: int | None = None,
        *,
        is_driven: bool = False,
    ) -> None:
        self.engines = {engine.name: engine for engine in engines}
        self._scope = scope
        by_kind = {kind: [one for one in functions if one.kind is kind] for kind in Kind}
        self._preprocessing, self._transceivers = by_kind[Kind.PREPROCESSING], by_kind[Kind.TRANSCEIVER]
        self._status = by_kind[Kind.STATUS]
        self._graph, self._graph_step_ns, self._is_driven = Graph(nodes), graph_step_ns, is_driven
        users: list[Function | Node] = [*functions, *nodes]
        asked = dict.fromkeys(one for user in users for one in user.requested())
        self._requested = {name: [one.name for one in asked if one.engine == name] for name in self.engines}
        self.iteration = 0
        self._inputs: dict[Identity, DataPack] = {}
        self._from_client: dict[Identity, DataPack] = {}
        self._preprocessed: dict[Identity, DataPack] = {}
        self._outputs: dict[Identity, DataPack] = {}
        self.done = False
        self.trajectory: list[Any] = []
        self._queue: list[tuple[int, Engine]] = []

    def initialize(self) -> None:
        """Initialize the engines, which are all due at time 0."""
        for engine in self.engines.values():
            engine.initialize()
        self._queue = [(0, engine) for engine in self.engines.values()]

    def shutdown(self) -> None:
        """End the engines."""
        for engine in self.engines.values():
            engine.shutdown()

    def reset(self) -> None:
        """Return to time 0; the variables of functions and the number of the iteration stay.

        Datapacks of a client that wait are sent first, but only to the first engine, as in NRP-core 4.
        """
        first = next(iter(self.engines.values()), None)
        if first is not None:
            self._send([first])
        for pool in self._pools:
            pool.clear()
        self._graph.reset()
        self.done, self.trajectory = False, []
        for engine in self.engines.values():
            engine.reset()
        self._queue = [(0, engine) for engine in self.engines.values()]

    @property
    def _pools(self) -> tuple[dict[Identity, DataPack], ...]:
        """Where datapacks are kept between iterations."""
        return self._inputs, self._preprocessed, self._outputs, self._from_client

    def requested(self) -> list[Any]:
        """Return the data of all datapacks that functions ask for, as engines have them now."""
        self._read(list(self.engines.values()))
        return [copied(pack.data) for pack in self._inputs.values() if not pack.isEmpty()]

    def set_datapack(self, pack: DataPack) -> None:
        """Send a datapack of a client in every later iteration, after those of functions.

        A datapack for an engine that does not exist has no effect, as in NRP-core 4.
        """
        self._from_client[pack.identity] = pack

    def iterate(self, t_ns: int) -> None:
        """Execute the actions due at a time; call it at each multiple of the common time step, in order.

        Raises:
            TransferFunctionRaisedError: a function raised.
            ExperimentError: an engine does not have or take a datapack.
        """
        due = [engine for end_ns, engine in self._queue if end_ns == t_ns]
        if not due and (self._graph_step_ns is None or t_ns % self._graph_step_ns):
            return
        self._read(due)
        self._preprocessed.update(self._run_all(self._preprocessing, due, self._inputs, t_ns))
        known = {**self._preprocessed, **self._inputs}
        self._outputs.update(self._run_graph(due, t_ns))
        self._outputs.update(self._run_all(self._transceivers, due, known, t_ns))
        for function in self._status:
            found = self._call(function, {**self._outputs, **known}, t_ns)
            self.done, data = status_of(function, found)
            self.trajectory += [copied(one) for one in data]
        self._send(due)
        self._end_iteration(due, t_ns)
        self._queue = [one for one in self._queue if one[0] != t_ns]
        for engine in due:
            engine.start_step()
            self._queue.append((t_ns + engine.step_ns, engine))
        self._queue.sort(key=lambda one: one[0])  # stable: earlier beginnings first
        self.iteration += 1

    def _end_iteration(self, due: Sequence[Engine], t_ns: int) -> None:
        """Mark datapacks as seen; in an event loop after its graph, and it sends each only once."""
        if self._graph_step_ns:
            names = {engine.name for engine in due}
            self._outputs = {
                key: pack for key, pack in self._outputs.items() if pack.engine_name not in names
            }
            if t_ns % self._graph_step_ns:
                return
        for pool in self._pools:
            for pack in pool.values():
                pack.updated = False

    def _run_graph(self, due: Sequence[Engine], t_ns: int) -> Mapping[Identity, DataPack]:
        """Run the nodes that engines need; in an event loop, run its nodes at its own steps."""
        needed = None
        if not self._graph_step_ns:
            needed = self._graph.needed_by([engine.name for engine in due])
        elif t_ns % self._graph_step_ns:
            return {}
        elif self._is_driven:
            needed = self._graph.needed_at(t_ns // self._graph_step_ns)
        now = {CLOCK: t_ns // NS_PER_MS, ITERATION: self.iteration}
        return self._graph.run(needed, self._inputs, self._guarded, now)

    def _read(self, engines: Sequence[Engine]) -> None:
        for engine in engines:
            names = self._requested[engine.name]
            for name, data in engine.read(names).items() if names else ():
                self._inputs[Identity(name, engine.name)] = DataPack(name, engine.name, data, updated=True)
            for name in names:
                identity = Identity(name, engine.name)
                self._inputs.setdefault(identity, DataPack(*identity))

    def _run_all(
        self,
        functions: Sequence[Function],
        due: Sequence[Engine],
        known: Mapping[Identity, DataPack],
        t_ns: int,
    ) -> dict[Identity, DataPack]:
        """Run the functions of engines; no function receives the result of another one."""
        made: dict[Identity, DataPack] = {}
        for engine in due:
            for function in functions:
                if function.engine == engine.name:
                    for pack in datapacks_of(function, self._call(function, known, t_ns)):
                        made[pack.identity] = pack
        return made

    def _call(self, function: Function, known: Mapping[Identity, DataPack], t_ns: int) -> Any:
        def find(identity: Identity) -> DataPack:
            if identity not in known:
                names = [one.name for one in known if one.engine == identity.engine]
                raise TransferFunctionError(
                    f"there is no datapack '{identity.name}' of '{identity.engine}'"
                    f"{did_you_mean(identity.name, names)}",
                    path=function.path,
                )
            return known[identity]

        return self._guarded(function, function.arguments(find, t_ns, self.iteration))

    def _guarded(self, function: Function | Node, arguments: dict[str, Any]) -> Any:
        try:
            return function.call(**arguments)
        except (Exception, SystemExit) as error:
            path = function.path
            assert path is not None
            located = self._scope.located(error, TransferFunctionError, path)
            raise TransferFunctionRaisedError(str(located)) from error

    def _send(self, engines: Sequence[Engine]) -> None:
        pool = {**self._from_client, **self._outputs}
        for pack in self._outputs.values():
            if pack.engine_name not in self.engines:
                hint = did_you_mean(pack.engine_name, self.engines)
                raise ExperimentError(
                    f"the datapack '{pack.name}' is for '{pack.engine_name}', which is not an engine{hint}"
                )
        for engine in engines:
            packs = [pack for pack in pool.values() if pack.engine_name == engine.name]
            if packs:
                engine.write(packs)
