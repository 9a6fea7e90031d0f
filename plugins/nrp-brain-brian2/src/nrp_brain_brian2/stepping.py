"""Step a network of Brian2 without preparing it again, as its own ``run`` does for each call."""

from __future__ import annotations

from typing import Any, Final

import brian2
import numpy as np
from nrp_core.brain import FloatArray, IntArray
from nrp_core.clock import nanoseconds

_FOREVER_S: Final = 1e6
"""The longest duration that Brian2 can count in steps of 0.1 ms without rounding."""
_NS: Final = 1e-9
_GROUPS: Final = (brian2.NeuronGroup, brian2.Synapses, brian2.core.spikesource.SpikeSource)
_SAME: Final = 1e-4
"""The share of a step by which equal times of two clocks of Brian2 may differ."""


class Stepper:
    """A network of Brian2 between two of its steps, with a random generator of its own.

    Args:
        network: the network, which has not run.
        namespace: the variables that its equations use.

    Attributes:
        steps_ns: the duration of the steps of the groups, or if it has none, of everything else.
    """

    def __init__(self, network: Any, namespace: Any) -> None:
        objects = network.sorted_objects
        self._network = network
        self._clocks = list({id(one.clock): one.clock for one in objects}.values())
        network._clocks = set(self._clocks)  # as run sets it, for operations that ask
        for clock in self._clocks:
            clock.set_interval(0 * brian2.second, _FOREVER_S * brian2.second)
        network.before_run(namespace)
        self._active = [one for one in objects if one.active]
        clocks = {one.clock for one in network.objects if isinstance(one, _GROUPS)} or self._clocks
        self.steps_ns = [int(nanoseconds(np.array([1e3 * float(clock.dt)]))[0]) for clock in clocks]
        self._random = np.random.get_state()  # noqa: NPY002  Brian2 draws from this generator

    def until(self, t_ns: int) -> None:
        """Carry out all steps that begin before a time."""
        own = np.random.get_state()  # noqa: NPY002
        np.random.set_state(self._random)  # noqa: NPY002
        try:
            self._step((t_ns - 1) * _NS)
            self._random = np.random.get_state()  # noqa: NPY002
        finally:
            np.random.set_state(own)  # noqa: NPY002

    def _step(self, last_s: float) -> None:
        network = self._network
        while (now_s := min(clock.t_ for clock in self._clocks)) <= last_s:
            due = {one for one in self._clocks if one.t_ - now_s < _SAME * one.dt_}
            network.t_ = now_s
            for one in self._active:
                if one._clock in due:
                    one.run()
            for clock in due:
                _advance(clock)


def _advance(clock: Any) -> None:
    """Let a clock go on by a step, as a run of Brian2 does, where newer versions have a method."""
    if hasattr(clock, "advance"):
        clock.advance()
        return
    step, time, dt = (clock.variables[name].get_value() for name in ("timestep", "t", "dt"))
    step[0] += 1
    time[0] = step[0] * dt[0]


class Ports:
    """Operations of a network that note the spikes of its groups and add input to them.

    Args:
        network: the network, which is not prepared yet.
        groups: its groups with the first global id of each.
    """

    def __init__(self, network: Any, groups: list[tuple[Any, int]]) -> None:
        self._spikes: list[tuple[IntArray, float]] = []
        self._arriving: dict[int, list[tuple[float, Any, IntArray, FloatArray]]] = {}
        for group, first in groups:
            if "_spikespace" in group.variables:
                network.add(self._operation(self._noting(group, first), group, "end"))
            network.add(self._operation(self._adding(group), group, "synapses"))

    def _operation(self, action: Any, group: Any, when: str) -> Any:
        return brian2.NetworkOperation(action, clock=group.clock, when=when)

    def _noting(self, group: Any, first: int) -> Any:
        space, clock = group.variables["_spikespace"], group.clock

        def note() -> None:
            found = space.get_value()
            if found[-1]:
                end_ms = 1e3 * (clock.variables["timestep"].get_value()[0] + 1) * clock.dt_
                self._spikes.append((found[: found[-1]] + first, end_ms))

        return note

    def _adding(self, group: Any) -> Any:
        clock, waiting = group.clock, self._arriving.setdefault(id(group), [])

        def add() -> None:
            if not waiting:
                return
            end_ns = int(nanoseconds(np.array([1e3 * (clock.t_ + clock.dt_)]))[0])
            later = []
            for event in waiting:
                time_ns, variable, cells, amounts = event
                if time_ns > end_ns:
                    later.append(event)
                    continue
                if variable.conditional_write is not None:  # Brian2 ignores input to a refractory membrane
                    amounts = amounts * variable.conditional_write.get_value()[cells]
                np.add.at(variable.get_value(), cells, amounts)
            waiting[:] = later

        return add

    def add(
        self, group: Any, variable: Any, cells: IntArray, times_ms: FloatArray, amounts: FloatArray
    ) -> None:
        """Let amounts (SI) be added to a variable of cells in the steps in which the given times lie."""
        times_ns = nanoseconds(times_ms)
        for time_ns in np.unique(times_ns).tolist():
            now = times_ns == time_ns
            self._arriving[id(group)].append((time_ns, variable, cells[now], amounts[now]))

    def take_spikes(self) -> tuple[IntArray, FloatArray]:
        """Return and clear the global ids and times (ms) of the spikes: the ends of their steps."""
        spikes, self._spikes = self._spikes, []
        if not spikes:
            return np.empty(0, np.int64), np.empty(0)
        times = np.repeat([time for _, time in spikes], [len(ids) for ids, _ in spikes])
        return np.concatenate([ids for ids, _ in spikes]).astype(np.int64), times
