"""PyNN's random numbers and random spaces, drawn from named streams unless the script seeds them.

A generator without a seed takes the name of its first user (a parameter of a population, the connector
of a projection), so that adding one object does not change the numbers of another.
"""

# mypy: disable-error-code="misc"

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from copy import deepcopy
from math import inf, isfinite
from numbers import Integral
from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt
from pyNN import random, space
from pyNN.parameters import LazyArray

from nrp_core._support.checked_arguments import is_number
from nrp_core.brain.network.drawing import compile_loop, pairs_among
from nrp_core.brain.pynn.arguments import WrongKindError, require_kind, require_names
from nrp_core.brain.pynn.simulator import Simulator
from nrp_core.errors import NetworkError, did_you_mean

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


class _Rule(NamedTuple):
    """What an argument must be, in words and as a test."""

    words: str
    holds: Callable[[Any], bool]


def _is_finite(value: Any) -> bool:
    return is_number(value) and isfinite(value)


def _are_three(value: Any) -> bool:
    return np.ndim(value) == 1 and len(value) == 3 and all(map(_is_finite, value))


def _are_bounds(value: Any) -> bool:
    """Return whether these are the borders of the three axes, None for an axis without."""
    ends = [one for one in value if one is not None] if isinstance(value, tuple | list) else [()]
    return all(np.ndim(one) == 1 and len(one) == 2 and all(map(_is_finite, one)) for one in ends)


_NUMBER: Final = _Rule("a finite number", _is_finite)
_RATIO: Final = _Rule("a number above 0", lambda value: _is_finite(value) and value > 0)
_SIZE: Final = _Rule("a number of 0 or more", lambda value: _is_finite(value) and value >= 0)
_ORDER: Final = _Rule("'sequential' or 'random'", lambda value: value in ("sequential", "random"))
_PLACE: Final = _Rule("three numbers", _are_three)
_ANY_PLACE: Final = _Rule("a number, or three", lambda value: _is_finite(value) or _are_three(value))
_GENERATOR: Final = _Rule(GENERATOR[1], lambda value: isinstance(value, GENERATOR[0]))
_SHAPE: Final = _Rule("one such as sim.Sphere(100.0)", lambda value: isinstance(value, space.Shape))
_AXES: Final = [name for name in space.Space.AXES if name is not None]
_STEPS: Final = ("dx", "dy", "dz")

_RULES: Final[Mapping[str, Mapping[str, _Rule]]] = {
    "Space": {
        "axes": _Rule(f"one of {', '.join(_AXES)}", lambda value: value is None or value in _AXES),
        "scale_factor": _Rule("a number other than 0", lambda value: _is_finite(value) and value != 0),
        "offset": _ANY_PLACE,
        "periodic_boundaries": _Rule(
            "the borders of three axes, such as ((0, 100), None, None)",
            lambda value: value is None or (len(value) == 3 if _are_bounds(value) else False),
        ),
    },
    "Line": dict.fromkeys(("dx", "x0", "y", "z"), _NUMBER),
    "Grid2D": {
        "aspect_ratio": _RATIO,
        **dict.fromkeys(("dx", "dy", "x0", "y0", "z"), _NUMBER),
        "fill_order": _ORDER,
        "rng": _GENERATOR,
    },
    "Grid3D": {
        **dict.fromkeys(("aspect_ratioXY", "aspect_ratioXZ"), _RATIO),
        **dict.fromkeys(("dx", "dy", "dz", "x0", "y0", "z0"), _NUMBER),
        "fill_order": _ORDER,
        "rng": _GENERATOR,
    },
    "RandomStructure": {"boundary": _SHAPE, "origin": _PLACE, "rng": _GENERATOR},
    "Cuboid": dict.fromkeys(("width", "height", "depth"), _SIZE),
    "Sphere": {"radius": _RATIO},
}


def checked_space() -> dict[str, type]:
    """Return PyNN's space, structures and shapes; their constructors refuse impossible arguments."""
    return {name: _checked(getattr(space, name), rules) for name, rules in _RULES.items()}


def are_at_one_place(structure: Any) -> bool:
    """Return whether a structure gives all cells one place, because no step between them is above 0."""
    steps = [getattr(structure, name) for name in _STEPS if hasattr(structure, name)]
    return bool(steps) and not any(steps)


def _checked(base: type, rules: Mapping[str, _Rule]) -> type:
    declared = inspect.signature(base)

    def begin(self: Any, *arguments: Any, **named: Any) -> None:
        try:
            given = declared.bind(*arguments, **named).arguments
        except TypeError as error:
            raise WrongKindError(f"{base.__name__}: {error}") from None
        for name, value in given.items():
            if not rules[name].holds(value):
                raise WrongKindError(
                    f"{base.__name__}: {name} is {value!r:.60}; it must be {rules[name].words}"
                )
        base.__init__(self, *arguments, **named)

    return type(base.__name__, (base,), {"__init__": begin, "__doc__": base.__doc__})
