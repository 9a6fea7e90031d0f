"""Synapses as ``GetConnections`` returns them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from typing import Any, NamedTuple

import numpy as np

from nrp_core.brain import IntArray
from nrp_pynest.kernel import Block, Kernel, Node
from nrp_pynest.parameters import Places, drawn, is_random


class Synapse(NamedTuple):
    """A synapse of NEST 2, with the array that contains it."""

    source: int
    target: int
    target_thread: int
    synapse_id: int
    port: int
    block: Block
    place: int


class Synapses(Sequence[Any]):
    """Synapses, with the methods of NEST 3; in old scripts each of them is a :class:`Synapse`.

    Args:
        kernel: the kernel.
        chosen: blocks of synapses, with the indices of these synapses in them.
    """

    _kernel: Kernel
    _chosen: list[tuple[Block, IntArray]]

    def __init__(self, kernel: Kernel, chosen: Sequence[tuple[Block, IntArray]]) -> None:
        vars(self).update(_kernel=kernel, _chosen=[(block, at) for block, at in chosen if len(at)])

    def __len__(self) -> int:
        return sum(len(at) for _, at in self._chosen)

    def __iter__(self) -> Iterator[Any]:
        return self._of_nest_2() if self._kernel.is_lenient else (self[k] for k in range(len(self)))

    def _of_nest_2(self) -> Iterator[Synapse]:
        for block, at in self._chosen:
            number = next(i for i, one in enumerate(self._kernel.blocks) if one is block)
            for k in at.tolist():
                yield Synapse(int(block.pre[k]), int(block.post[k]), 0, number, k, block, k)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, (int, np.integer)):
            place = range(len(self))[index]
            return list(self)[place] if self._kernel.is_lenient else self[place : place + 1]
        kept = np.zeros(len(self), bool)
        kept[index] = True
        ends = np.cumsum([0, *(len(at) for _, at in self._chosen)])
        return Synapses(
            self._kernel,
            [
                (block, at[kept[first:last]])
                for (block, at), first, last in zip(self._chosen, ends, ends[1:], strict=False)
            ],
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Synapses) and list(self._of_nest_2()) == list(other._of_nest_2())

    __hash__ = None  # type: ignore[assignment]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or not self or name not in self._names():
            raise AttributeError(f"synapses do not have the attribute '{name}'")
        return self.get(name)

    def __setattr__(self, name: str, value: Any) -> None:
        self.set({name: value})

    def _names(self) -> list[str]:
        return [*_ENDS, *dict.fromkeys(name for block, _ in self._chosen for name in block.values)]

    def sources(self) -> Iterator[Node]:
        """Return the source of each."""
        return iter([Node.of(self._kernel, one) for one in self._column("source")])

    def targets(self) -> Iterator[Node]:
        """Return the target of each."""
        return iter([Node.of(self._kernel, one) for one in self._column("target")])

    def set(self, params: Any = None, **fields: Any) -> None:
        """Set parameters: a number, a value for each, or a parameter such as ``nest.random.normal()``."""
        if isinstance(params, (list, tuple)):  # a dictionary for each
            names = dict.fromkeys(name for one in params for name in one)
            given = {name: [one[name] for one in params] for name in names}
        else:
            given = {**(params or {}), **fields}
        with self._kernel.changing() if self else nullcontext():
            for name, value in given.items():
                self._set(name, value)

    def _set(self, name: str, value: Any) -> None:
        n = len(self)
        values = drawn(value, Places(n, self._kernel.random)) if is_random(value) else value
        each, done = np.broadcast_to(np.asarray(values, float), (n,)), 0
        for block, at in self._chosen:
            column = np.array(block.values.get(name, np.full(len(block.pre), np.nan)), float)
            column[at] = each[done : done + len(at)]
            block.values[name] = column
            done += len(at)

    def get(self, names: Any = None, output: str = "") -> Any:
        """Return a parameter: one value for one synapse, else a list; a dictionary for several names."""
        self._kernel.read_weights()
        if isinstance(names, str):
            values = self._column(names)
            return values[0] if len(values) == 1 else values
        table = {name: self._column(name) for name in names or self._names()}
        if output == "pandas":
            import pandas as pd

            return pd.DataFrame(table)
        return {key: one[0] for key, one in table.items()} if len(self) == 1 else table

    def _column(self, name: str) -> list[Any]:
        found: list[Any] = []
        for block, at in self._chosen:
            if name in ("source", "target"):
                found += (block.pre if name == "source" else block.post)[at].tolist()
            elif name == "synapse_model":
                found += [block.model] * len(at)
            else:
                found += block.values[name][at].tolist() if name in block.values else [None] * len(at)
        return found

    def rows(self) -> tuple[dict[str, Any], ...]:
        """Return the parameters of each as a dictionary."""
        self._kernel.read_weights()
        columns = [self._column(name) for name in self._names()]
        return tuple(dict(zip(self._names(), row, strict=True)) for row in zip(*columns, strict=True))


_ENDS = ("source", "target", "synapse_model")


def among(nodes: IntArray, wanted: Sequence[int] | None) -> Any:
    """Return which nodes are among others; all if there are none to be among."""
    return np.ones(len(nodes), bool) if wanted is None else np.isin(nodes, list(map(int, wanted)))


def synapses_between(kernel: Kernel, sources: Any, targets: Any, model: str | None) -> Synapses:
    """Return the synapses from some nodes to others, of a model if it is given."""
    return Synapses(
        kernel,
        [
            (block, np.flatnonzero(among(block.pre, sources) & among(block.post, targets)))
            for block in kernel.blocks
            if (model is None or block.model == model) and not kernel.is_device(block)
        ],
    )


def collected(synapses: Any) -> Synapses:
    """Return one or several synapses of NEST 2 as a collection."""
    several = [synapses] if isinstance(synapses, Synapse) else synapses
    if isinstance(several, Synapses):
        return several
    kernel = several[0].block.kernel
    return Synapses(kernel, [(one.block, np.array([one.place])) for one in several])
