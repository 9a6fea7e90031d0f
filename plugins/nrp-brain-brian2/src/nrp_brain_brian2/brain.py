"""A script of Brian2 as a brain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import lcm
from typing import Any

import brian2
import numpy as np
from nrp_core.brain import (
    Brain,
    BrainCapabilities,
    FloatArray,
    IntArray,
    ProcessLock,
    Spikes,
    SynapticEvents,
    no_variable,
)
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.native import NativeNetwork
from nrp_core.seeds import Seeds

from nrp_brain_brian2.options import NAME, RECEPTORS, Brian2Options
from nrp_brain_brian2.script import execute, scale_of
from nrp_brain_brian2.stepping import Ports, Stepper


class Brian2Brain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`.

    Spikes are at the end of the step of Brian2 in which the threshold was crossed. States and inputs are in
    mV, nA and uS where a variable has that dimension, and otherwise in SI.

    Raises:
        LifecycleError: another brain of this process uses Brian2.
        NetworkError, CapabilityError: as for :func:`~nrp_brain_brian2.script.execute`.
    """

    reads_parameters = False

    def __init__(
        self, network: NativeNetwork, seed: int, capabilities: BrainCapabilities, options: Brian2Options
    ) -> None:
        self._script, self._options = network.script, options
        self._lock = ProcessLock(NAME)
        try:
            self._build(network, seed)
            names = {name for group, _ in self._groups for name in _arrays(group)}
            capabilities = replace(
                capabilities,
                resolution_ns=lcm(*self._stepper.steps_ns),
                state_variables=capabilities.state_variables | names,
            )
            identity = f"brian2:{options.model_dump_json()}"
            super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        except BaseException:
            self._lock.release()
            raise

    def _build(self, network: NativeNetwork, seed: int) -> None:
        """Execute the script and prepare its network for the first step."""
        built = execute(self._script, seed_of(seed), compiled=self._options.compiled)
        sizes = {label: len(group) for label, group in built.groups.items()}
        if sizes != {label: one.size for label, one in network.populations.items()}:
            raise NetworkError("the groups differ from those of the last time it was read", path=self._script)
        self._groups = [(group, network.offsets[label]) for label, group in built.groups.items()]
        self._ports = Ports(built.network, self._groups)
        self._stepper = Stepper(built.network, built.namespace)
        self._base: dict[str, FloatArray] = {}

    def _members(self, neurons: IntArray) -> Iterator[tuple[Any, IntArray, IntArray]]:
        """Yield each group with some of the neurons, their indices in it, and their places in it."""
        for group, first in self._groups:
            places = np.flatnonzero((neurons >= first) & (neurons < first + len(group)))
            if len(places):
                yield group, neurons[places] - first, places

    def _do_run_until(self, t_ns: int) -> None:
        self._stepper.until(t_ns)

    def _do_take_spikes(self) -> Spikes:
        return Spikes(*self._ports.take_spikes())

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        raise NotImplementedError("a script of Brian2 has no cells whose spikes come from outside")

    def _do_inject(self, events: SynapticEvents) -> None:
        times_ms = np.maximum(events.times_ms, milliseconds(self.now_ns))
        for group, cells, places in self._members(events.neurons):
            variable = self._receptor(group, events.receptor)
            amounts = events.weights[places] * scale_of(variable)
            self._ports.add(group, variable, cells, times_ms[places], amounts)

    def _receptor(self, group: Any, receptor: str) -> Any:
        named = self._options.inputs.get(receptor)  # type: ignore[call-overload]
        names = RECEPTORS[receptor] if named is None else (named,)
        for name in names:
            if name in _arrays(group):
                return group.variables[name]
        raise CapabilityError(
            f"the group '{self._label(group)}' has no variable {' or '.join(map(repr, names))} for spikes of "
            f"devices; name one in the brain's options: 'inputs: {{{receptor}: NAME}}'"
        )

    def _do_set_current(self, currents_na: FloatArray) -> None:
        for group, first in self._groups:
            wanted, label = currents_na[first : first + len(group)], self._label(group)
            if label not in self._base and not wanted.any():
                continue
            variable = self._current(group, label)
            held = variable.get_value()
            base = self._base.setdefault(label, np.array(held, float))
            held[:] = base + wanted * scale_of(variable)

    def _current(self, group: Any, label: str) -> Any:
        named = self._options.inputs.get("current")
        own = getattr(getattr(group, "equations", None), "parameter_names", ())
        found = [name for name in own if group.variables[name].dim is brian2.amp.dim]
        names = [named] if named is not None else found
        if len(names) != 1 or names[0] not in own:
            raise CapabilityError(
                f"the group '{label}' needs one parameter in ampere for the currents of devices, not "
                f"{', '.join(names) or 'none'}; name a parameter of its equations in the brain's options: "
                "'inputs: {current: NAME}'"
            )
        if len(group.variables[names[0]].get_value()) != len(group):
            raise CapabilityError(
                f"the parameter '{names[0]}' of the group '{label}' is one for all its cells"
            )
        return group.variables[names[0]]

    def _label(self, group: Any) -> str:
        first = next(first for one, first in self._groups if one is group)
        return next(name for name in self.network.populations if self.network.offsets[name] == first)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        values = np.zeros(len(neurons))
        for group, cells, places in self._members(neurons):
            known = _arrays(group).get(variable)
            if known is None:
                raise no_variable(self._label(group), variable)
            held = known.get_value()
            values[places] = (held[cells] if len(held) == len(group) else held[0]) / scale_of(known)
        return values

    def _do_reset(self, seed: int) -> None:
        assert isinstance(self.network, NativeNetwork)
        self._build(self.network, seed)

    def _do_close(self) -> None:
        self._lock.release()


def seed_of(seed: int) -> int:
    """Return the seed of Brian2's generator for a seed of the brain."""
    return Seeds(seed).integer("brian2")


def _arrays(group: Any) -> Mapping[str, Any]:
    """Return the variables of a group that are numbers of its cells, by name."""
    return {
        name: one
        for name, one in group.variables.items()
        if isinstance(one, brian2.core.variables.ArrayVariable)
        and one.owner is not None
        and one.owner.name == group.name
        and not name.startswith("_")
        and np.issubdtype(one.dtype, np.number)
    }
