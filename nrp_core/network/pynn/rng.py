"""PyNN's random numbers, drawn from named streams unless the script seeds them.

A generator without a seed takes the name of its first user (a parameter of a population, the connector
of a projection), so that adding one object does not change the numbers of another.
"""

# mypy: disable-error-code="misc"

from __future__ import annotations

from copy import deepcopy
from math import inf
from numbers import Integral
from typing import Any

import numpy as np
import numpy.typing as npt
from pyNN import random
from pyNN.parameters import LazyArray

from nrp_core._support.checked_arguments import is_number
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.drawing import compile_loop, pairs_among
from nrp_core.network.pynn.arguments import require_kind, require_names
from nrp_core.network.pynn.simulator import Simulator

Indices = npt.NDArray[np.int32]

_BLOCK = 1 << 20
_FEW = 1 << 14
"""Up to this number of pairs, Python takes less time than loading a compiler."""


def random_pairs(rng: Any, n_first: int, n_second: int, n: int) -> tuple[Indices, Indices]:
    """Return ``n`` pairs of integers below ``n_first`` and ``n_second``.

    The numbers equal those of PyNN's loop over synapses (one integer, one choice, and so on), and the
    generator ends in the same state.
    """
    if not isinstance(rng, random.NumpyRNG):
        return _one_by_one(rng, n_first, n_second, n)
    state: np.random.RandomState = rng.rng
    if n_first == 1 or n_second == 1:  # drawing from a range of one does not advance the generator
        first, second = (state.randint(0, high, size=n).astype(np.int32) for high in (n_first, n_second))
        return first, second
    return _interleaved(state, n_first, n_second, n)


def _one_by_one(rng: Any, n_first: int, n_second: int, n: int) -> tuple[Indices, Indices]:
    pairs = np.empty((2, n), np.int32)
    choices = np.arange(n_second)
    for i in range(n):
        pairs[0, i] = rng.next(1, "uniform_int", {"low": 0, "high": n_first}, mask=None)[0]
        pairs[1, i] = rng.choice(choices, size=1)[0]
    return pairs[0], pairs[1]


def _interleaved(
    state: np.random.RandomState, n_first: int, n_second: int, n: int
) -> tuple[Indices, Indices]:
    """Draw by NumPy's rule for bounded integers: masked 32-bit words, those out of range rejected."""
    high = np.array([n_first, n_second], np.uint32)
    masks = np.array([(1 << (size - 1).bit_length()) - 1 for size in (n_first, n_second)], np.uint32)
    pairs, at = np.empty((2, n), np.int32), np.zeros(2, np.int64)
    take = pairs_among if n <= _FEW else compile_loop(pairs_among)
    while at[0] < n:
        before = state.get_state(legacy=False)
        words, at[1] = _words(state, min(_BLOCK, 8 * (n - int(at[0])) + 8)), 0
        take(words, high, masks, pairs, at)
        state.set_state(before)
        _words(state, int(at[1]))
    return pairs[0], pairs[1]


def _words(state: np.random.RandomState, n: int) -> npt.NDArray[np.uint32]:
    return state.randint(0, 1 << 32, size=n, dtype=np.uint32)


GENERATOR = (random.AbstractRNG, type(None)), "a generator such as sim.NumpyRNG(seed=1), or None"
"""The classes of generators, and what they are in words."""
_SIZES = frozenset({"sigma", "beta", "k", "theta", "kappa", "lambda_"})
"""Parameters of distributions that are never negative."""


class NumpyRNG(random.NumpyRNG):
    """PyNN's wrapper of NumPy's generators.

    Args:
        seed: the seed of a Mersenne Twister, as in PyNN; without one the numbers come from a named stream.
        parallel_safe: as in PyNN.
    """

    _simulator: Simulator

    def __init__(self, seed: int | None = None, parallel_safe: bool = True) -> None:
        require_kind(type(self).__name__, "seed", seed, (Integral, type(None)), "a whole number, or None")
        random.WrappedRNG.__init__(self, None if seed is None else int(seed), parallel_safe)
        self._generator = None if self.seed is None else np.random.RandomState(self.seed)

    @property
    def rng(self) -> np.random.RandomState:
        """The generator itself."""
        if self._generator is None:
            self._generator = self._simulator.state.stream()
        return self._generator

    def take_name(self, name: str) -> None:
        """Draw from the stream of ``name``, unless seeded or named before."""
        if self._generator is None:
            self._generator = self._simulator.state.stream(name)

    def __deepcopy__(self, memo: dict[int, Any]) -> NumpyRNG:
        copy = type(self)(self.seed, self.parallel_safe)
        copy._generator = deepcopy(self._generator, memo)
        return copy


class NativeRNG(NumpyRNG):
    """The simulator's own generator; here it is the core's."""


class RandomDistribution(random.RandomDistribution):
    """PyNN's distribution; without a generator its numbers come from a named stream."""

    _simulator: Simulator

    def __init__(
        self, distribution: str, parameters_pos: Any = None, rng: Any = None, **parameters_named: Any
    ) -> None:
        known = random.available_distributions
        if not isinstance(distribution, str) or distribution not in known:
            raise NetworkError(
                f"there is no distribution '{distribution}'{did_you_mean(distribution, known)}"
            )
        require_names(f"the distribution '{distribution}'", parameters_named, known[distribution])
        require_kind(f"the distribution '{distribution}'", "rng", rng, *GENERATOR)
        rng = rng or self._simulator.types["NumpyRNG"]()
        try:
            super().__init__(distribution, parameters_pos, rng, **parameters_named)
        except (KeyError, TypeError, ValueError) as error:
            raise NetworkError(f"the distribution '{distribution}': {error.args[0]}") from None
        values = self.parameters
        for name, value in values.items():
            if not isinstance(value, LazyArray | np.ndarray) and not is_number(value):
                raise NetworkError(
                    f"the distribution '{distribution}': {name} is {value!r:.60}, not a number"
                )
        for name in _SIZES & values.keys():
            if not values[name] >= 0:
                raise NetworkError(f"the distribution '{distribution}': {name} is {values[name]}, below 0")
        if values.get("low", 0) > values.get("high", inf):
            raise NetworkError(
                f"the distribution '{distribution}': low is {values['low']}, above high, {values['high']}"
            )


def named(rng: Any, simulator: Simulator, name: str) -> Any:
    """Return a generator for ``name``: the given one if it has a seed."""
    if rng is None or (type(rng) is random.NumpyRNG and rng.seed is None):
        rng = simulator.types["NumpyRNG"]()
    if isinstance(rng, NumpyRNG):
        rng.take_name(name)
    return rng


def name_streams(values: Any, simulator: Simulator, owner: str) -> None:
    """Name the generators of all random values among lazy arrays, ``owner/<their key>``."""
    for key, value in values.items():
        base = value.base_value if isinstance(value, LazyArray) else value
        if isinstance(base, random.RandomDistribution):
            base.rng = named(base.rng, simulator, f"{owner}/{key}")


def are_at_one_place(structure: Any) -> bool:
    """Return whether a structure gives all cells one place, because no step between them is above 0."""
    steps = [getattr(structure, name) for name in ("dx", "dy", "dz") if hasattr(structure, name)]
    return bool(steps) and not any(steps)
