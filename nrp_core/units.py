"""Units: SI units with prefixes, their products and quotients, such as ``mV``, ``Hz/mV`` or ``uF/cm**2``.

All conversions use the tables of this module. Equations have the names of Brian2 and their scales as floats;
parameters of scripts and quantities in experiment files are converted exactly.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from math import pi
from typing import Any, Final, TypeAlias

from nrp_core.errors import did_you_mean

Dimension = tuple[Fraction, ...]
"""Exponents of kilogram, metre, second, ampere, kelvin, mole and radian."""
_Size: TypeAlias = tuple[Any, Dimension]
"""The size of a unit in SI units, a float or a fraction, and its dimension."""

_BASE: Final = ("kg", "m", "s", "A", "K", "mol", "rad")
_PREFIXES: Final = {
    "": 0, "f": -15, "p": -12, "n": -9, "u": -6, "m": -3, "c": -2, "k": 3, "M": 6, "G": 9,
}  # fmt: skip
"""The power of ten of each prefix; equations have ``c`` only for metres."""
_UNITS: Final[dict[str, tuple[str, float, tuple[int, ...]]]] = {
    "V": ("volt", 1.0, (1, 2, -3, -1)),
    "A": ("amp ampere", 1.0, (0, 0, 0, 1)),
    "s": ("second", 1.0, (0, 0, 1)),
    "Hz": ("hertz", 1.0, (0, 0, -1)),
    "S": ("siemens", 1.0, (-1, -2, 3, 2)),
    "ohm": ("", 1.0, (1, 2, -3, -2)),
    "F": ("farad", 1.0, (-1, -2, 4, 2)),
    "C": ("coulomb", 1.0, (0, 0, 1, 1)),
    "m": ("metre meter", 1.0, (0, 1)),
    "g": ("gram", 1e-3, (1,)),
    "K": ("kelvin", 1.0, (0, 0, 0, 0, 1)),
    "mol": ("mole", 1.0, (0, 0, 0, 0, 0, 1)),
    "M": ("molar", 1e3, (0, -3, 0, 0, 0, 1)),
    "J": ("joule", 1.0, (1, 2, -2)),
    "W": ("watt", 1.0, (1, 2, -3)),
    "N": ("newton", 1.0, (1, 1, -2)),
    "Pa": ("pascal", 1.0, (1, -1, -2)),
}
"""Other names of each unit, its size in SI units, and its dimension."""
_LARGEST_POWER: Final = 9
_ANGLE: Final = (0, 0, 0, 0, 0, 0, 1)
_OTHERS: Final[dict[str, tuple[Fraction, tuple[int, ...]]]] = {
    "min": (Fraction(60), (0, 0, 1)),
    "h": (Fraction(3600), (0, 0, 1)),
    "deg": (Fraction(pi) / 180, _ANGLE),
    "%": (Fraction(1, 100), ()),
    "Nm": (Fraction(1), (1, 2, -2)),
}
"""Units that equations do not have, without prefixes."""
_SPELLINGS: Final = {"\u00b5": "u", "\u03bc": "u", "°": "deg", "Ω": "Ohm", "ohm": "Ohm", "\u00b7": "*"}
"""The micro sign and the Greek letter look alike; the middle dot is a product."""
NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?"
"""The pattern of a number; an exponent of four digits is beyond any float."""
_JUXTAPOSED: Final = re.compile(r"(?<=\w)\s+(?=[^\W\d])")
_QUANTITY: Final = re.compile(rf"\s*({NUMBER})\s*(?:\*(?!\*))?\s*(.*?)\s*\Z")


def dimension(*exponents: int) -> Dimension:
    """Return the dimension with these exponents; the rest are 0."""
    return tuple(map(Fraction, (*exponents, *[0] * (len(_BASE) - len(exponents)))))


NONE: Final = dimension()
SECOND: Final = dimension(0, 0, 1)
AMPERE: Final = dimension(0, 0, 0, 1)
SIEMENS: Final = dimension(-1, -2, 3, 2)
VOLT: Final = dimension(1, 2, -3, -1)


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as written.

    Args:
        text: how it was written.
        scale: its size in SI units.
        dimension: its dimension.
    """

    text: str
    scale: float
    dimension: Dimension


@cache
def units() -> Mapping[str, Unit]:
    """Return every unit, with all prefixes."""
    found = {"dimensionless": Unit("dimensionless", 1.0, NONE), "radian": Unit("radian", 1.0, NONE)}
    for text, power, size, exponents in _with_prefixes():
        if power == _PREFIXES["c"] and exponents != _UNITS["m"][2]:
            continue
        found.setdefault(text, Unit(text, float(Fraction(10) ** power) * size, dimension(*exponents)))
    return found


def _with_prefixes() -> Iterator[tuple[str, int, float, tuple[int, ...]]]:
    """Yield every name with every prefix, its power of ten, and the size and dimension without it."""
    for symbol, (names, size, exponents) in _UNITS.items():
        for prefix, power in _PREFIXES.items():
            yield from ((prefix + name, power, size, exponents) for name in (symbol, *names.split()))


def _in_equations(name: str) -> _Size:
    if name not in units():
        raise ValueError(f"'{name}' is not a unit{did_you_mean(name, units())}")
    return units()[name].scale, units()[name].dimension


def _exact(name: str) -> _Size:
    """Return the exact size of a unit with its prefix; an angle is not a plain number here."""
    if name in _OTHERS:
        exact, exponents = _OTHERS[name]
        return exact, dimension(*exponents)
    for symbol, (names, size, exponents) in _UNITS.items():
        for written in (plain(symbol), *names.split()):
            prefix = name.removesuffix(written)
            if prefix != name and prefix in _PREFIXES:
                return Fraction(10) ** _PREFIXES[prefix] * Fraction(str(size)), dimension(*exponents)
    prefix = name.removesuffix("rad")
    if prefix != name and prefix in _PREFIXES:
        return Fraction(10) ** _PREFIXES[prefix], dimension(*_ANGLE)
    raise ValueError(f"'{name}' is not a unit")


def factor(unit: str, to: str) -> Fraction:
    """Return the number of units ``to`` in one ``unit``; powers may be written with ``^``.

    Raises:
        ValueError: the two measure different things, or one is unknown.
    """
    if plain(unit) == plain(to):
        return Fraction(1)
    one, other = _exact_size(unit), _exact_size(to)
    if one is None or other is None:
        raise ValueError(f"'{unit if one is None else to}' is not a unit that can be converted")
    if one[1] != other[1]:
        raise ValueError(f"'{unit}' cannot be converted to '{to}'")
    return one[0] / other[0]


def correct_spelling(unit: str) -> str:
    """Return the simple unit with the same letters as an unknown one, or an empty text."""
    if _exact_size(unit) is not None:
        return ""
    letters = sorted(plain(unit))
    return next((name for name, *_ in _with_prefixes() if sorted(name) == letters), "")


def plain(unit: str) -> str:
    """Return a unit in ASCII, without spaces."""
    for written, ascii_name in _SPELLINGS.items():
        unit = unit.replace(written, ascii_name)
    return unit.replace(" ", "")


@cache
def _exact_size(unit: str) -> tuple[Fraction, Dimension] | None:
    """Return the size in SI units and the dimension of a unit; None if it is unknown.

    A space is a product, as in ``N m``, but not below a slash, where it is ambiguous.
    """
    above, slash, below = unit.partition("/")
    written = plain(_JUXTAPOSED.sub("*", above.strip()) + slash + below).replace("^", "**")
    if written in ("", *_OTHERS):
        return _exact(written) if written else (Fraction(1), NONE)
    try:
        return _measure(_parse(written), written, _exact)
    except (ValueError, SyntaxError):
        return None


@lru_cache(maxsize=256)
def unit_of(text: str) -> Unit:
    """Return a unit such as ``mV``, ``1/ms`` or ``uF/cm**2``.

    Raises:
        ValueError: the text is not a unit.
    """
    written = text.strip().replace("\u00b5", "u").replace("\u03bc", "u")
    if not written:
        raise ValueError("the unit is missing; a number without a unit has the unit 1")
    if "^" in written:
        raise ValueError(f"'{written}': a power is written with **, e.g. cm**2")
    try:
        parsed = _parse(written)
    except SyntaxError:
        raise ValueError(f"'{written}' is not a unit; write e.g. mV, 1/ms or uF/cm**2") from None
    scale, dimensions = _measure(parsed, written, _in_equations)
    return Unit(written, float(scale), dimensions)


def _parse(text: str) -> ast.expr:
    return ast.parse(f"1{text}" if text.startswith("/") else text, mode="eval").body


def quantity(text: str) -> tuple[float, Unit]:
    """Return number and unit of a text such as ``20 ms``, ``20*ms`` or ``0.02/ms``; without a unit, 1.

    Raises:
        ValueError: the text is not a quantity.
    """
    match = _QUANTITY.match(text)
    if match is None:
        raise ValueError(f"'{text}' is not a number with a unit; write e.g. '20 ms'")
    number, unit = match.groups()
    return float(number), unit_of(unit or "1")


def as_unit(of: Dimension) -> str:
    """Return a dimension as a unit, e.g. ``V/s``."""
    known = {dimension(*exponents): symbol for symbol, (_, _, exponents) in reversed(_UNITS.items())}
    known[NONE], known[dimension(0, 0, -1)] = "1", "1/s"
    if of in known:
        return known[of]
    for made in _combinations(of):
        return made
    powers = [f"{name}^{power}" for name, power in zip(_BASE, of, strict=True) if power]
    return " ".join(powers)


def times(a: Dimension, b: Dimension, power: int = 1) -> Dimension:
    """Return the dimension of ``a * b ** power``."""
    return tuple(x + power * y if y else x for x, y in zip(a, b, strict=True))


def _combinations(of: Dimension) -> Iterator[str]:
    """Yield a dimension as a quotient or product of two units."""
    simple = {symbol: dimension(*_UNITS[symbol][2]) for symbol in ("V", "A", "S", "F", "C", "m", "s")}
    for power, sign in ((-1, "/"), (-2, "/"), (1, "*")):
        for first, a in simple.items():
            for second, b in simple.items():
                if times(a, b, power) == of:
                    yield f"{first}{sign}{second}" + ("**2" if power == -2 else "")


def _measure(node: ast.expr, text: str, size_of: Callable[[str], _Size]) -> _Size:
    """Return the size and the dimension of a parsed unit, from those of its names."""
    match node:
        case ast.Name(id=name):
            return size_of(name)
        case ast.Constant(value=1):
            return 1, NONE
        case ast.BinOp(left=left, op=ast.Mult() | ast.Div() as op, right=right):
            power = 1 if isinstance(op, ast.Mult) else -1
            (a, first), (b, second) = _measure(left, text, size_of), _measure(right, text, size_of)
            return a * b**power, times(first, second, power)
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            exponent = ast.literal_eval(right) if _is_number(right) else None
            if not isinstance(exponent, int) or abs(exponent) > _LARGEST_POWER:
                raise ValueError(
                    f"'{text}': the power of a unit is a whole number of at most {_LARGEST_POWER}"
                )
            scale, base = _measure(left, text, size_of)
            return scale**exponent, times(NONE, base, exponent)
    raise ValueError(f"'{text}' is not a unit; write e.g. mV, 1/ms or uF/cm**2")


def _is_number(node: ast.expr) -> bool:
    return isinstance(node.operand if isinstance(node, ast.UnaryOp) else node, ast.Constant)
