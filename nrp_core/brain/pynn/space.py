"""PyNN's space and structures, whose arguments are checked where they are given."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any, Final, NamedTuple

import numpy as np
from pyNN import space

from nrp_core._support.numbers import is_number
from nrp_core.brain.pynn.invalid import WrongKindError
from nrp_core.brain.pynn.rng import GENERATOR


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
        base.__init__(self, *arguments, **named)  # type: ignore[misc]

    return type(base.__name__, (base,), {"__init__": begin, "__doc__": base.__doc__})
