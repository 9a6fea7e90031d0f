"""The far end: opens a brain and carries out requests."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, Final, NamedTuple

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.changes import ParameterChange, Rewirings, Synapses, projection_of
from nrp_core.brain.interface import Brain
from nrp_core.brain.network.data import Network
from nrp_core.brain.remote.messages import Channel, SharedColumns, carry_out, write_spikes
from nrp_core.errors import BackendLoadError, NrpError, SimulationError
from nrp_core.findings import Finding


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
            return REQUESTS[request](self, *arguments), None
        except Exception as error:  # noqa: BLE001  whatever it is, the other side raises it
            return None, _portable(error, SimulationError if hasattr(self, "_brain") else BackendLoadError)

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

    def read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        """Return a state variable."""
        return self._brain._do_read_state(variable, neurons)

    def set_parameters(self, change: ParameterChange) -> None:
        """Change parameters of cells."""
        self._brain._do_set_parameters(change)

    def read_weights(self, label: str) -> FloatArray:
        """Return the weights of a projection."""
        return self._brain._do_read_weights(projection_of(self._brain.network, label))

    def read_synapses(self, label: str) -> Synapses:
        """Return the synapses of a projection whose synapses form and vanish."""
        return self._brain._do_read_synapses(projection_of(self._brain.network, label))

    def read_rewirings(self, label: str) -> Rewirings:
        """Return which synapses of a projection formed and vanished."""
        return self._brain._do_read_rewirings(projection_of(self._brain.network, label))

    def set_weights(self, label: str, weights: FloatArray) -> None:
        """Change the weights of a projection."""
        self._brain._do_set_weights(projection_of(self._brain.network, label), weights)

    def set_synapse_parameters(self, label: str, values: Mapping[str, FloatArray]) -> None:
        """Change parameters of synapses in equations."""
        self._brain._do_set_synapse_parameters(projection_of(self._brain.network, label), values)

    def set_plastic(self, label: str, plastic: bool) -> None:
        """Stop or continue the learning of a projection."""
        self._brain._do_set_plastic(projection_of(self._brain.network, label), plastic)

    def reward(self, population: str, amount: float) -> None:
        """Add to the dopamine of all cells of a population."""
        self._brain._do_reward(population, amount)

    def hold_reward(self, population: str, value: float) -> None:
        """Set the value that adds to the dopamine of all cells of a population."""
        self._brain._do_hold_reward(population, value)

    def read_synapse_state(self, label: str, variable: str) -> FloatArray:
        """Return a state variable of synapses that learn from rewards."""
        return self._brain._do_read_synapse_state(projection_of(self._brain.network, label), variable)

    def save(self) -> object:
        """Return the state."""
        return self._brain._do_save()

    def restore(self, saved: object) -> None:
        """Restore a state."""
        self._brain._do_restore(saved)

    def close(self) -> None:
        """Close the brain, if one was opened."""
        if hasattr(self, "_brain"):
            self._brain.close()
            del self._brain


REQUESTS: Final[Mapping[str, Callable[..., object]]] = {
    name: getattr(BrainServer, name)
    for name in (
        "open",
        "reset",
        "read_state",
        "set_parameters",
        "read_weights",
        "read_synapses",
        "read_rewirings",
        "set_weights",
        "set_synapse_parameters",
        "set_plastic",
        "reward",
        "hold_reward",
        "read_synapse_state",
        "save",
        "restore",
        "close",
    )
}


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
