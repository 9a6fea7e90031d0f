"""A network in one of PyNN's simulators."""

from __future__ import annotations

from importlib import import_module

from nrp_core.brain import (
    Brain,
    BrainCapabilities,
    FloatArray,
    Grid,
    IntArray,
    Network,
    ParameterChange,
    ProcessLock,
    Projection,
    Spikes,
    SynapticEvents,
)

from nrp_brain_pynn.checks import check
from nrp_brain_pynn.driver import Driver
from nrp_brain_pynn.loading import quietly
from nrp_brain_pynn.options import PyNNOptions


class PyNNBrain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`.

    PyNN builds the network; a driver steps it, because PyNN's ``run`` and ``get_data`` are designed for one
    long run.

    Raises:
        LifecycleError: another brain of this process uses the simulator.
        CapabilityError: the simulator cannot simulate the network.
    """

    def __init__(
        self, network: Network, seed: int, capabilities: BrainCapabilities, options: PyNNOptions
    ) -> None:
        self._options, chosen = options, options.chosen
        identity = f"pynn:{options.model_dump_json()}"
        capabilities.require(network, f"PyNN's {chosen.name}")
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        self._grid = Grid(options.timestep, chosen.name)
        check(network, chosen)
        self._right = ProcessLock(chosen.name)
        try:
            self._driver = self._build()
        except BaseException:
            self._right.release()
            raise
        self.warnings += self._driver.warnings

    def _build(self) -> Driver:
        module, _, name = self._options.chosen.driver.partition(":")
        with quietly():
            made: Driver = getattr(import_module(module), name)(self.network, self._grid, self._options)
        return made

    def _do_run_until(self, t_ns: int) -> None:
        self._driver.run_until(self._grid.number_of(t_ns))

    def _do_take_spikes(self) -> Spikes:
        return self._driver.take_spikes()

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        self._driver.fire(neurons, times_ms)

    def _do_inject(self, events: SynapticEvents) -> None:
        self._driver.inject(events)

    def _do_set_current(self, currents_na: FloatArray) -> None:
        self._driver.set_currents(currents_na)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        return self._driver.read(variable, neurons)

    def _do_set_parameters(self, change: ParameterChange) -> None:
        self._driver.set_parameters(change)

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        return self._driver.read_weights(projection)

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        self._driver.set_weights(projection, weights)

    def _do_reset(self, seed: int) -> None:
        self._driver.close()
        self._driver = self._build()

    def _do_close(self) -> None:
        self._driver.close()
        self._right.release()
