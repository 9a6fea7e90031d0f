"""The far end: opens a brain and does what it is asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, Final, Literal, NamedTuple, TypeAlias

from nrp_core.brain.changes import ParameterChange, projection_of
from nrp_core.brain.interface import Brain, BrainBackend, BrainOptions
from nrp_core.brain.network import FloatArray, IntArray, Network
from nrp_core.brain.remote.messages import receive, send
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.errors import NrpError, SimulationError

Order: TypeAlias = tuple[Literal["fire", "inject", "set_current"], tuple[Any, ...]]
"""One of a brain's inputs, and its arguments; plain tuples and arrays, which pickle fast."""


class Opened(NamedTuple):
    """What the near end must know of a brain.

    Args:
        warnings: the brain's.
        emitting: labels of the source populations whose spikes the simulator emits itself.
    """

    warnings: list[str]
    emitting: frozenset[str]


class BrainServer:
    """Carries out requests by the operations that a backend writes: checks and draws are the near end's."""

    _brain: Brain

    def answer(self, request: str, arguments: tuple[Any, ...]) -> tuple[object, NrpError | None]:
        """Return what a request returns, or raises."""
        try:
            return REQUESTS[request](self, *arguments), None
        except Exception as error:  # noqa: BLE001  whatever it is, the other side raises it
            return None, _portable(error)

    def open(self, backend: BrainBackend, network: Network, seed: int, options: BrainOptions) -> Opened:
        """Open the brain."""
        self._brain = brain = backend.open(network, seed=seed, options=options)
        own = {p.label for p in network.populations.values() if p.is_source and brain._emits(p)}
        return Opened(brain.warnings, frozenset(own))

    def run(self, now_ns: int, orders: Sequence[Order], t_ns: int) -> tuple[IntArray, FloatArray]:
        """Carry out the orders given since the last run, run, and return ids and times (ms) of the spikes."""
        brain = self._brain
        brain._now_ns = now_ns
        for order, arguments in orders:
            if order == "inject":
                brain._do_inject(SynapticEvents(*arguments))
            elif order == "fire":
                brain._do_fire(*arguments)
            else:
                brain._do_set_current(*arguments)
        brain._do_run_until(t_ns)
        brain._now_ns = t_ns
        spikes = brain._do_take_spikes()
        return spikes.neurons, spikes.times_ms

    def reset(self, seed: int) -> None:
        """Go back to time 0."""
        self._brain._seed, self._brain._now_ns = seed, 0
        self._brain._do_reset(seed)

    def read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        """Return a state variable."""
        return self._brain._do_read_state(variable, neurons)

    def set_parameters(self, change: ParameterChange) -> None:
        """Change parameters of cells."""
        self._brain._do_set_parameters(change)

    def read_weights(self, label: str) -> FloatArray:
        """Return the weights of a projection."""
        return self._brain._do_read_weights(projection_of(self._brain.network, label))

    def set_weights(self, label: str, weights: FloatArray) -> None:
        """Change the weights of a projection."""
        self._brain._do_set_weights(projection_of(self._brain.network, label), weights)

    def save(self) -> object:
        """Return the state."""
        return self._brain._do_save()

    def restore(self, saved: object) -> None:
        """Go back to a state."""
        self._brain._do_restore(saved)

    def close(self) -> None:
        """Close the brain, if one was opened."""
        if hasattr(self, "_brain"):
            self._brain.close()


REQUESTS: Final[Mapping[str, Callable[..., object]]] = {
    name: getattr(BrainServer, name)
    for name in (
        "open",
        "run",
        "reset",
        "read_state",
        "set_parameters",
        "read_weights",
        "set_weights",
        "save",
        "restore",
    )
}


def serve(connection: Connection) -> None:
    """Answer requests, each with what it returns or raises, until the other side is gone."""
    server = BrainServer()
    with suppress(EOFError, ConnectionError):
        while True:
            request, arguments = receive(connection)
            send(connection, server.answer(request, arguments))
    server.close()


def _portable(error: Exception) -> NrpError:
    """Return an error that exists on the other side, too."""
    if isinstance(error, NrpError):
        error.__cause__ = error.__context__ = None
        return error
    return SimulationError(f"{type(error).__name__}: {error}")
