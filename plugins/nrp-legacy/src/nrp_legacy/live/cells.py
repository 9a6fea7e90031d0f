"""Neurons of a brain file, and their recordings, for transfer functions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from nrp_pynest.built import BuiltBrain

from nrp_core.brain import FloatArray, IntArray
from nrp_core.dsl import Selection, Selector
from nrp_core.errors import CapabilityError, NetworkError, did_you_mean

State = tuple[str, FloatArray, FloatArray]
"""A variable, times (ms), and values of shape ``(n, n_cells)``."""

_UNITS = {"v": "mV", "gsyn_exc": "uS", "gsyn_inh": "uS"}


def block_of(
    name: str, ids: Iterable[int], spikes: FloatArray, states: Iterable[State], now_ms: float
) -> Any:
    """Return a block with one segment: a train for each cell, and a signal for each state variable.

    Args:
        name: the name of the cells.
        ids: the cells.
        spikes: index of the cell and time (ms) of each spike, shape ``(n, 2)``.
        states: the samples of state variables.
        now_ms: the time, at which the trains end.
    """
    import neo

    class Segment(neo.Segment):  # type: ignore[misc]
        @property
        def analogsignalarrays(self) -> Any:
            """The signals, as Neo called them before 0.5."""
            return self.analogsignals

    segment = Segment()
    segment.analogsignals.extend([_signal(*state) for state in states])
    for i, cell in enumerate(ids):
        times = np.minimum(spikes[spikes[:, 0] == i, 1], now_ms)
        segment.spiketrains.append(
            neo.SpikeTrain(times, t_stop=now_ms, units="ms", source_id=cell, source_index=i)
        )
    block = neo.Block(name=name)
    block.segments.append(segment)
    return block


def _signal(variable: str, times_ms: FloatArray, values: FloatArray) -> Any:
    import neo
    from quantities import ms

    step_ms = times_ms[1] - times_ms[0] if len(times_ms) > 1 else 1.0
    begin_ms = times_ms[0] if len(times_ms) else 0.0
    return neo.AnalogSignal(
        values, units=_UNITS.get(variable, ""), name=variable,
        t_start=begin_ms * ms, sampling_period=step_ms * ms,
    )  # fmt: skip


_OWN = frozenset({"_find", "_text", "_built", "_ids"})


class Cells(Selector):
    """Neurons: a selector with a size and the methods of PyNN's populations.

    Args:
        built: the objects of the brain file.
        text: their text representation.
        ids: global ids.
    """

    __slots__ = ("_built", "_ids")

    def __init__(self, built: BuiltBrain, text: str, ids: IntArray) -> None:
        super().__init__(lambda root: Selection(ids, text, root._network), text)
        self._built, self._ids = built, ids

    def __reduce__(self) -> tuple[Any, ...]:
        return Cells, (self._built, self._text, self._ids)

    def __deepcopy__(self, memo: object) -> Cells:
        return self

    def __len__(self) -> int:
        return len(self._ids)

    def __int__(self) -> int:
        """Return the number of one cell's node in NEST."""
        (node,) = self.nodes()
        return node

    item = __int__

    def nodes(self) -> list[int]:
        """Return the numbers of their nodes in NEST."""
        return [self._built.node_of(cell) for cell in self._ids.tolist()]

    def __getitem__(self, index: Any) -> Selector:
        if isinstance(index, (int, np.integer, slice, list, tuple, np.ndarray)):
            chosen = Selection(self._ids, self._text)[index].ids
            return Cells(self._built, super().__getitem__(index)._text, chosen)
        return super().__getitem__(index)

    def __iter__(self) -> Iterator[Selector]:  # type: ignore[override]
        return (self[i] for i in range(len(self._ids)))

    def __add__(self, other: Any) -> Selector:
        if isinstance(other, Cells):
            ids = np.concatenate([self._ids, other._ids])
            return Cells(self._built, f"({self._text} + {other._text})", ids)
        return super().__add__(other)

    def __getattr__(self, name: str) -> Any:
        if name in self._parameter_names():
            return self.get(name)
        return super().__getattr__(name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _OWN:
            super().__setattr__(name, value)
        else:
            self.set(**{name: value})

    def _parameter_names(self) -> frozenset[str]:
        network = self._built.network
        labels = {network.label_of(int(cell))[0] for cell in self._ids[:1]}
        return frozenset(name for label in labels for name in network.populations[label].parameters)

    @property
    def ids(self) -> IntArray:
        """Their global ids."""
        return self._ids

    @property
    def size(self) -> int:
        """The number of neurons."""
        return len(self._ids)

    @property
    def label(self) -> str:
        """Their name."""
        return self._text

    @property
    def all_cells(self) -> list[Selector]:
        """Each of them."""
        return list(self)

    local_cells = all_cells

    # -- parameters

    def get(self, names: Any, *_how: Any, **_options: Any) -> Any:
        """Return a parameter: one number if all are equal, as in PyNN; for several names a list.

        Raises:
            NetworkError: none of the cells has a parameter of this name.
        """
        if not isinstance(names, str):
            return [self.get(name) for name in names]
        values = self._built.parameter(names)[self._ids]
        if values.size and np.isnan(values).all():
            hint = did_you_mean(names, self._parameter_names())
            raise NetworkError(f"{self._text} has no parameter '{names}'{hint}")
        return float(values[0]) if values.size and (values == values[0]).all() else values.copy()

    def set(self, *old: Any, **parameters: Any) -> None:
        """Change their parameters."""
        if old:
            given = {old[0]: old[1]} if isinstance(old[0], str) else dict(old[0])
            parameters = {**given, **parameters}
        self._built.set_parameters(self._ids, parameters)

    def initialize(self, *_values: Any, **_variables: Any) -> None:
        """Refuse to change state variables.

        Raises:
            CapabilityError: always.
        """
        raise CapabilityError(
            f"{self._text}.initialize() sets the state at time 0, so only the brain file can call it"
        )

    def rset(self, name: str, values: Any) -> None:
        """Set an individual value of a parameter for each."""
        self.set(**{name: values})

    tset = rset

    # -- spikes

    def record(self, variables: Any = "spikes", *_where: Any, **_how: Any) -> None:
        """Record their spikes, and state variables, from now on."""
        for variable in [variables] if isinstance(variables, str) else variables or ():
            if variable == "spikes":
                self._built.record(self._ids)
            else:
                self._built.record_state(variable, self._ids)

    def getSpikes(self, *_how: Any, **_options: Any) -> FloatArray:  # noqa: N802 - PyNN 0.7
        """Return the spikes so far, shape ``(n, 2)``: index of the cell, time (ms)."""
        spikes = self._built.spikes(self._ids)
        order = np.argsort(self._ids, kind="stable")
        places = order[np.searchsorted(self._ids, spikes.neurons, sorter=order)]
        return np.column_stack([places.astype(float), spikes.times_ms])

    def get_data(
        self, variables: Any = "all", _gather: bool = True, clear: bool = False, **_options: Any
    ) -> Any:
        """Return the spikes and recorded state variables so far as a Neo block, one train per cell.

        Args:
            variables: accepted.
            clear: whether they are forgotten then.
        """
        states = list(self._built.states(self._ids))
        block = block_of(self._text, self._ids.tolist(), self.getSpikes(), states, self._built.now_ms)
        if clear:
            self._built.clear(self._ids)
        return block

    def get_spike_counts(self, *_how: Any, **_options: Any) -> dict[int, int]:
        """Return the number of spikes of each, by id."""
        neurons = self._built.spikes(self._ids).neurons
        return {cell: int((neurons == cell).sum()) for cell in self._ids.tolist()}

    def mean_spike_count(self, *_how: Any, **_options: Any) -> float:
        """Return their mean number of spikes."""
        return float(len(self._built.spikes(self._ids)) / max(len(self._ids), 1))

    meanSpikeCount = mean_spike_count
