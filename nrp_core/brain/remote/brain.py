"""The near end: a brain that forwards all calls to another process."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, Self

from pydantic import Field

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.brain.interface import Brain
from nrp_core.brain.remote.messages import Inputs, Label, read_spikes
from nrp_core.brain.remote.process import borrow, give_back, is_locked
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import seconds
from nrp_core.network.data import Network, Population, Projection
from nrp_core.quantities import DurationNs

if TYPE_CHECKING:
    from nrp_core.brain.remote.server import Opened

DEFAULT_LIMIT_NS: Final = 60_000_000_000


class RemoteOptions(BrainOptions):
    """Options of a backend whose brains can run in their own processes."""

    python: str | None = Field(
        default=None,
        description="the Python that runs the simulator in its own process, e.g. VENV/bin/python; "
        "by default the simulator runs in this process",
    )
    time_limit: DurationNs = Field(
        default=DEFAULT_LIMIT_NS,
        description="the time for which that process may neither answer nor compute before the run fails",
    )

    def here(self) -> Self:
        """Return the options of the brain in the other process."""
        return self.model_copy(update={"python": None})

    def elsewhere(self, simulator: str) -> str | None:
        """Return the Python for another process, or None if the brain can run in this one.

        Args:
            simulator: a simulator that can run once in a process: a second brain gets its own process.
        """
        return self.python or (sys.executable if is_locked(simulator) else None)


def _forwarded(operation: str) -> Any:
    """Return the method that lets the brain in the other process carry out an operation."""

    def forward(self: RemoteBrain, *arguments: Any) -> Any:
        portable = (Label(one.label) if isinstance(one, Projection) else one for one in arguments)
        return self._process.call(operation, *portable)

    return forward


class RemoteBrain(Brain):
    """A brain whose simulator runs in another process.

    Args:
        backend: the brain's backend; the other process opens the brain with it.
        network: the simulated network.
        seed: the seed of the brain's random numbers.
        options: the backend's options in the other process.
        python: the interpreter of that process: a path, or a name on the search path.

    Raises:
        BackendLoadError: the process does not start.
        SimulationError: it ends, or hangs.
        NrpError: any error that the backend raises there.
    """

    def __init__(
        self, backend: BrainBackend, network: Network, *, seed: int, options: BrainOptions, python: str
    ) -> None:
        limit_ns = options.time_limit if isinstance(options, RemoteOptions) else DEFAULT_LIMIT_NS
        self._process = borrow(python, type(backend).__module__, seconds(limit_ns))
        try:
            opened: Opened = self._process.call("open", backend, network, seed, options)
        except BaseException:
            self._process.close()
            raise
        self._emitting = opened.emitting
        super().__init__(
            network,
            seed=seed,
            capabilities=replace(backend.capabilities(options), releases_gil=True),
            identity=f"{type(backend).__qualname__}:{options.model_dump_json(exclude={'time_limit'})}",
        )
        self.warnings += opened.warnings
        self._inputs, self._spikes = Inputs(), list[Spikes]()

    def _do_run_until(self, t_ns: int) -> None:
        self.begin_run(t_ns)
        self.end_run()

    def begin_run(self, t_ns: int) -> None:
        """Let the other process run to a time, while this one does something else."""
        inputs, self._inputs = self._inputs, Inputs()
        self._process.begin_step(self.now_ns, t_ns, *inputs.write(self._process.columns))

    def end_run(self) -> None:
        """Wait until the other process has reached the time."""
        n_spikes, *_ = self._process.end_step()
        if n_spikes:
            self._spikes.append(read_spikes(self._process.columns, n_spikes))

    def _do_take_spikes(self) -> Spikes:
        spikes, self._spikes = self._spikes, []
        return spikes[0] if len(spikes) == 1 else Spikes.merged(spikes)

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        self._inputs.fire(neurons, times_ms)

    def _do_inject(self, events: SynapticEvents) -> None:
        self._inputs.inject(events)

    def _do_set_current(self, currents_na: FloatArray) -> None:
        self._inputs.set_current(currents_na)

    def _do_reset(self, seed: int) -> None:
        self._forget()
        self._process.call("reset", seed)

    _do_read_state = _forwarded("_do_read_state")
    _do_set_parameters = _forwarded("_do_set_parameters")
    _do_read_weights = _forwarded("_do_read_weights")
    _do_read_synapses = _forwarded("_do_read_synapses")
    _do_read_rewirings = _forwarded("_do_read_rewirings")
    _do_set_weights = _forwarded("_do_set_weights")
    _do_set_synapse_parameters = _forwarded("_do_set_synapse_parameters")
    _do_set_plastic = _forwarded("_do_set_plastic")
    _do_reward = _forwarded("_do_reward")
    _do_hold_reward = _forwarded("_do_hold_reward")
    _do_read_synapse_state = _forwarded("_do_read_synapse_state")
    _do_save = _forwarded("_do_save")

    def _do_restore(self, saved: object) -> None:
        self._forget()
        self._process.call("_do_restore", saved)

    def _emits(self, population: Population) -> bool:
        return population.label in self._emitting

    def _do_close(self) -> None:
        give_back(self._process)

    def _forget(self) -> None:
        """Discard pending inputs and spikes, which belong to the time before a reset or restore."""
        self._inputs, self._spikes = Inputs(), []
