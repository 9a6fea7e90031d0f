"""Units of parameters: SI units with prefixes, their products and quotients, such as ``mV`` or ``Hz/mV``."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import cache
from math import pi
from typing import TypeAlias

_PREFIXES = {"f": -15, "p": -12, "n": -9, "u": -6, "m": -3, "c": -2, "": 0, "k": 3, "M": 6, "G": 9}
_BASES = ("s", "Hz", "m", "g", "V", "A", "F", "S", "Ohm", "N", "J", "W", "rad", "mol", "K")
_OTHERS = {
    "min": (Fraction(60), "s"),
    "h": (Fraction(3600), "s"),
    "deg": (Fraction(pi) / 180, "rad"),
    "%": (Fraction(1, 100), ""),
}
_SPELLINGS = {"µ": "u", "μ": "u", "°": "deg", "Ω": "Ohm", "ohm": "Ohm"}

Dimension: TypeAlias = tuple[tuple[str, int], ...]


def factor(unit: str, to: str) -> Fraction:
    """Return the number of units ``to`` in one ``unit``.

    Raises:
        ValueError: the two measure different things, or one is unknown.
    """
    one, other = _read(unit), _read(to)
    if plain(unit) == plain(to):
        return Fraction(1)
    if one is None or other is None:
        raise ValueError(f"'{unit if one is None else to}' is not a unit that can be converted")
    if one[1] != other[1]:
        raise ValueError(f"'{unit}' cannot be converted to '{to}'")
    return one[0] / other[0]


def meant_by(unit: str) -> str:
    """Return the simple unit of which an unknown one has the letters in another order, or an empty text."""
    if _read(unit) is not None:
        return ""
    letters = sorted(plain(unit))
    names = (prefix + base for base in _BASES for prefix in _PREFIXES)
    return next((name for name in names if sorted(name) == letters), "")


def plain(unit: str) -> str:
    """Return a unit in ASCII, without spaces."""
    for written, ascii_name in _SPELLINGS.items():
        unit = unit.replace(written, ascii_name)
    return unit.replace(" ", "")


@cache
def _read(unit: str) -> tuple[Fraction, Dimension] | None:
    """Return the size of a unit in SI units, and its dimension; None if it is unknown."""
    size, powers = Fraction(1), dict[str, int]()
    for sign, name, power in re.findall(r"([*/]?)([^*/^]*)(?:\^(-?\d))?", plain(unit))[:-1]:
        exponent = (-1 if sign == "/" else 1) * int(power or 1)
        if name == "1":
            continue
        found = _simple(name)
        if found is None:
            return None
        size *= found[0] ** exponent
        powers[found[1]] = powers.get(found[1], 0) + exponent
    return size, tuple(sorted((base, power) for base, power in powers.items() if base and power))


def _simple(name: str) -> tuple[Fraction, str] | None:
    if name in _OTHERS:
        return _OTHERS[name]
    for base in _BASES:
        prefix = name.removesuffix(base)
        if prefix != name and prefix in _PREFIXES:
            return Fraction(10) ** _PREFIXES[prefix], base
    return None
