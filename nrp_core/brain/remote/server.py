"""The far end: opens a brain and carries out requests."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.interface import Brain
from nrp_core.brain.remote.messages import Channel, Label, SharedColumns, carry_out, write_spikes
from nrp_core.errors import BackendLoadError, NrpError, SimulationError
from nrp_core.findings import Finding
from nrp_core.network.changes import projection_of
from nrp_core.network.data import Network


class Opened(NamedTuple):
    """The properties of a brain that the near end needs.

    Args:
        warnings: the brain's warnings.
        emitting: labels of the source populations whose spikes the simulator emits itself.
    """

    warnings: Sequence[Finding | str]
    emitting: frozenset[str]


class BrainServer:
    """Carries out requests by the backend's own operations; the near end does the checks and random draws."""

    _brain: Brain

    def answer(self, request: str, arguments: tuple[Any, ...]) -> tuple[object, NrpError | None]:
        """Return the result of a request, or raise its error."""
        try:
            own = getattr(self, request, None)
            return (own or self._forwarded(request))(*arguments), None
        except Exception as error:  # noqa: BLE001  whatever it is, the other side raises it
            return None, _portable(error, SimulationError if hasattr(self, "_brain") else BackendLoadError)

    def _forwarded(self, request: str) -> Callable[..., object]:
        """Return an operation of the brain, which takes the label of a projection for the projection."""
        operation, network = getattr(self._brain, request), self._brain.network
        return lambda *arguments: operation(
            *(projection_of(network, one.label) if isinstance(one, Label) else one for one in arguments)
        )

    def open(self, backend: BrainBackend, network: Network, seed: int, options: BrainOptions) -> Opened:
        """Open the brain."""
        self._brain = brain = backend.open(network, seed=seed, options=options)
        own = {p.label for p in network.populations.values() if p.is_source and brain._emits(p)}
        return Opened(brain.warnings, frozenset(own))

    def step(self, memory: SharedColumns, now_ns: int, t_ns: int, *counts: int) -> int:
        """Apply the inputs since the last step, run, and return the number of spikes."""
        brain = self._brain
        brain.now_ns = now_ns
        carry_out(brain, memory, counts)
        brain._do_run_until(t_ns)
        brain.now_ns = t_ns
        return write_spikes(memory, brain._do_take_spikes())

    def reset(self, seed: int) -> None:
        """Reset to time 0."""
        self._brain._seed, self._brain.now_ns = seed, 0
        self._brain._do_reset(seed)

    def close(self) -> None:
        """Close the brain, if one was opened."""
        if hasattr(self, "_brain"):
            self._brain.close()
            del self._brain


def serve(channel: Channel) -> None:
    """Answer each request with its result or error, until the other side closes."""
    server = BrainServer()
    with suppress(EOFError, ConnectionError):
        while True:
            message, numbers = channel.receive()
            if message is not None:
                channel.send(server.answer(*message))
                continue
            try:
                n_spikes = server.step(channel.columns, *numbers)
            except Exception as error:  # noqa: BLE001  whatever it is, the other side raises it
                channel.send((None, _portable(error)))
            else:
                channel.send_step(n_spikes)
    server.close()


def _portable(error: Exception, kind: type[NrpError] = SimulationError) -> NrpError:
    """Return an error whose class exists on the other side too."""
    if isinstance(error, NrpError):
        error.__cause__ = error.__context__ = None
        return error
    return kind(f"{type(error).__name__}: {error}")
