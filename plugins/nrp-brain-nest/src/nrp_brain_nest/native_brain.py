"""A script of PyNEST as a brain."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from nrp_core.brain import (
    RECEPTORS,
    Brain,
    BrainCapabilities,
    FloatArray,
    Grid,
    IntArray,
    ProcessLock,
    Spikes,
    SynapticEvents,
    flushing_subnormals,
    no_variable,
)
from nrp_core.clock import from_milliseconds, milliseconds
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.native import NativeNetwork

from nrp_brain_nest.generators import SpikeGenerators
from nrp_brain_nest.kernel import NAME
from nrp_brain_nest.native_script import execute, values_of
from nrp_brain_nest.options import NestOptions
from nrp_brain_nest.recorder import Recorder

_PER_KILO = 1000.0
"""NEST's pA and nS in the nA and uS of devices."""


class NativeNestBrain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`. Resolution, threads and seed are the script's.

    Raises:
        LifecycleError: another brain of this process uses NEST.
        NetworkError: as for :func:`~nrp_brain_nest.native_script.execute`.
        CapabilityError: an option is set that the script decides.
    """

    reads_parameters = False

    def __init__(
        self, network: NativeNetwork, seed: int, capabilities: BrainCapabilities, options: NestOptions
    ) -> None:
        for name in sorted({"resolution", "threads"} & options.model_fields_set):
            raise CapabilityError(f"a native script sets its {name} itself; remove the option '{name}'")
        self._right = ProcessLock(NAME)
        try:
            self._build(network, seed)
            names = {name for each in self._recordables.values() for name in each}
            capabilities = replace(
                capabilities,
                resolution_ns=from_milliseconds(float(self._nest.resolution)),
                state_variables=capabilities.state_variables | names | {"v"},
                changes=frozenset(),
                rewards=False,
            )
            identity = f"nest:{options.model_dump_json()}"
            super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        except BaseException:
            self._do_close()
            raise

    def _build(self, network: NativeNetwork, seed: int) -> None:
        """Execute the script, and connect a recorder to its neurons."""
        built = execute(network.script, seed)
        sizes = {label: len(nodes) for label, nodes in built.nodes.items()}
        if sizes != {label: one.size for label, one in network.populations.items()}:
            raise NetworkError(
                "the neurons differ from those of the last time it was read", path=network.script
            )
        self._nest = nest = built.nest
        self._reached_ns = 0
        self._grid = Grid(from_milliseconds(float(nest.resolution)), NAME)
        self._nodes = np.concatenate([np.empty(0, np.int64), *built.nodes.values()])
        self._models = values_of(nest, self._nodes, "model") if len(self._nodes) else np.empty(0, str)
        self._recordables = {
            str(one): _readable(nest.GetDefaults(str(one))) for one in np.unique(self._models)
        }
        self._base: FloatArray | None = None
        self._generators = SpikeGenerators(nest, self._grid, weighted=True)
        self._numbers = np.full((len(RECEPTORS), len(self._nodes)), -1)
        self._delay_ms = max(float(nest.min_delay), float(nest.resolution))  # one that is there already
        self._recorder = Recorder(nest, self._nodes, self._grid, delay_ms=self._delay_ms)
        for model in self._recordables:
            with suppress(nest.NESTError):  # a rate neuron or an astrocyte, which sends no spikes
                self._recorder.listen(self._nodes[self._models == model])

    def _do_run_until(self, t_ns: int) -> None:
        self._generators.feed(self._grid.number_of(t_ns))
        with flushing_subnormals():
            self._nest.Simulate(milliseconds(t_ns - self._reached_ns))
        self._reached_ns = t_ns

    def _do_take_spikes(self) -> Spikes:
        return self._recorder.take()

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        raise NotImplementedError("a script of PyNEST has no cells whose spikes come from outside")

    def _do_inject(self, events: SynapticEvents) -> None:
        number = RECEPTORS.index(events.receptor)
        models = self._models[events.neurons]
        weights = np.array(events.weights, float)
        for model in np.unique(models):
            weights[models == model] *= _scale(str(model), events.receptor)
        numbers = self._numbers[number]
        new = np.unique(events.neurons[numbers[events.neurons] < 0])
        if len(new):
            numbers[new], generators = self._generators.add(len(new))
            self._connect(generators, new, number)
        delay = self._grid.number_of(from_milliseconds(self._delay_ms))
        steps = self._grid.first_at(events.times_ms) - delay
        steps = np.maximum(steps, self._grid.number_of(self.now_ns) + 1)
        self._generators.send(numbers[events.neurons], steps, weights)

    def _connect(self, generators: IntArray, cells: IntArray, number: int) -> None:
        size = len(cells)
        synapses: dict[str, Any] = {"weight": np.ones(size), "delay": np.full(size, self._delay_ms)}
        receptors = np.array([self._receptor(str(one), number) for one in self._models[cells]])
        if receptors.any():
            synapses["receptor_type"] = receptors
        self._nest.Connect(generators, self._nodes[cells], "one_to_one", synapses)

    def _receptor(self, model: str, number: int) -> int:
        if "multisynapse" in model:
            return 1 + number
        if self._nest.GetDefaults(model).get("receptor_types"):
            raise CapabilityError(
                f"NEST's model '{model}' names its receptors, which spikes of devices cannot choose; connect "
                "a parrot_neuron in the script and drive that"
            )
        return 0

    def _do_set_current(self, currents_na: FloatArray) -> None:
        driven = np.flatnonzero(currents_na)
        missing = [one for one in driven if "I_e" not in self._nest.GetDefaults(str(self._models[one]))]
        if missing:
            raise CapabilityError(
                f"NEST's model '{self._models[missing[0]]}' takes no current of a device: it has no I_e"
            )
        if self._base is None:
            self._base = np.zeros(len(self._nodes))
            has = self._driveable()
            self._base[has] = values_of(self._nest, self._nodes[has], "I_e")
        has = self._driveable()
        order = has[np.argsort(self._nodes[has])]
        values = self._base[order] + _PER_KILO * currents_na[order]
        self._nest.NodeCollection(self._nodes[order].tolist()).set(I_e=values.tolist())

    def _driveable(self) -> IntArray:
        known = {one: "I_e" in self._nest.GetDefaults(one) for one in self._recordables}
        return np.flatnonzero([known[str(one)] for one in self._models])

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        name = "V_m" if variable == "v" else variable
        for cell in neurons:
            if name not in self._recordables[str(self._models[cell])]:
                label = next(one for one in self.network.populations if cell in self.network.ids_of(one))
                raise no_variable(label, variable)
        found: FloatArray = values_of(self._nest, self._nodes[neurons], name)
        return found

    def _do_reset(self, seed: int) -> None:
        assert isinstance(self.network, NativeNetwork)
        self._build(self.network, seed)

    def _do_close(self) -> None:
        if hasattr(self, "_nest"):
            self._nest.ResetKernel()
        self._right.release()


def _readable(defaults: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the state variables of a model that NEST records and also shows at the present time."""
    return tuple(name for name in map(str, defaults.get("recordables", ())) if name in defaults)


def _scale(model: str, receptor: str) -> float:
    """Return NEST's weight for a device's weight of 1 nA, uS or mV; inhibitory conductances are negative."""
    if "delta" in model or model.startswith("parrot"):
        return 1.0
    return -_PER_KILO if "cond" in model and receptor == "inhibitory" else _PER_KILO
