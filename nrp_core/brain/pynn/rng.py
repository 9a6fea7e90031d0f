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
from pyNN import random
from pyNN.parameters import LazyArray

from nrp_core._support.numbers import is_number
from nrp_core.brain.pynn.arguments import require_kind, require_names
from nrp_core.brain.pynn.simulator import Simulator
from nrp_core.errors import NetworkError, did_you_mean

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
