"""Physical units in equations, by the names that Brian2 has too, and their dimensions."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Final

from nrp_core.errors import did_you_mean

Dimension = tuple[Fraction, ...]
"""Exponents of kilogram, metre, second, ampere, kelvin and mole."""

_BASE: Final = ("kg", "m", "s", "A", "K", "mol")
_PREFIXES: Final = {
    "": 1.0, "f": 1e-15, "p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9,
}  # fmt: skip
_UNITS: Final = {
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
_QUANTITY: Final = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(?:\*(?!\*))?\s*(.*?)\s*\Z")


def dimension(*exponents: int) -> Dimension:
    """Return the dimension with these exponents; the rest are 0."""
    return tuple(map(Fraction, (*exponents, *[0] * (len(_BASE) - len(exponents)))))


NONE: Final = dimension()
SECOND: Final = dimension(0, 0, 1)
AMPERE: Final = dimension(0, 0, 0, 1)
SIEMENS: Final = dimension(-1, -2, 3, 2)
VOLT: Final = dimension(1, 2, -3, -1)
FARAD: Final = dimension(-1, -2, 4, 2)


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as it was written.

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
    for symbol, (names, size, exponents) in _UNITS.items():
        for prefix, factor in _PREFIXES.items():
            if prefix == "c" and symbol != "m":
                continue
            for name in (symbol, *names.split()):
                text = prefix + name
                found.setdefault(text, Unit(text, factor * size, dimension(*exponents)))
    return found


_MICRO: Final = str.maketrans("\u00b5\u03bc", "uu")
"""The micro sign and the Greek letter, which look alike."""


def unit_of(text: str) -> Unit:
    """Return a unit such as ``mV``, ``1/ms`` or ``uF/cm**2``.

    Raises:
        ValueError: the text is not a unit.
    """
    written = text.strip().translate(_MICRO)
    if not written:
        raise ValueError("the unit is missing; a number without a unit has the unit 1")
    if "^" in written:
        raise ValueError(f"'{written}': a power is written with **, e.g. cm**2")
    try:
        parsed = ast.parse(f"1{written}" if written.startswith("/") else written, mode="eval").body
    except SyntaxError:
        raise ValueError(f"'{written}' is not a unit; write e.g. mV, 1/ms or uF/cm**2") from None
    scale, dimensions = _measured(parsed, written)
    return Unit(written, scale, dimensions)


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


def described(of: Dimension) -> str:
    """Return a dimension as a unit, e.g. ``V/s``."""
    known = {dimension(*exponents): symbol for symbol, (_, _, exponents) in reversed(_UNITS.items())}
    known[NONE], known[dimension(0, 0, -1)] = "1", "1/s"
    if of in known:
        return known[of]
    for made in _combined(of):
        return made
    powers = [f"{name}^{power}" for name, power in zip(_BASE, of, strict=True) if power]
    return " ".join(powers)


def times(a: Dimension, b: Dimension, power: int = 1) -> Dimension:
    """Return the dimension of ``a * b ** power``."""
    return tuple(x + power * y for x, y in zip(a, b, strict=True))


def _combined(of: Dimension) -> Iterator[str]:
    """Yield a dimension as a quotient or product of two units."""
    simple = {symbol: dimension(*_UNITS[symbol][2]) for symbol in ("V", "A", "S", "F", "C", "m", "s")}
    for power, sign in ((-1, "/"), (-2, "/"), (1, "*")):
        for first, a in simple.items():
            for second, b in simple.items():
                if times(a, b, power) == of:
                    yield f"{first}{sign}{second}" + ("**2" if power == -2 else "")


def _measured(node: ast.expr, text: str) -> tuple[float, Dimension]:
    match node:
        case ast.Name(id=name):
            if name not in units():
                raise ValueError(f"'{name}' is not a unit{did_you_mean(name, units())}")
            return units()[name].scale, units()[name].dimension
        case ast.Constant(value=1):
            return 1.0, NONE
        case ast.BinOp(left=left, op=ast.Mult() | ast.Div() as op, right=right):
            power = 1 if isinstance(op, ast.Mult) else -1
            (a, first), (b, second) = _measured(left, text), _measured(right, text)
            return a * b**power, times(first, second, power)
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            exponent = ast.literal_eval(right) if _is_number(right) else None
            if not isinstance(exponent, int):
                raise ValueError(f"'{text}': the power of a unit is a whole number")
            scale, base = _measured(left, text)
            return float(scale**exponent), times(NONE, base, exponent)
    raise ValueError(f"'{text}' is not a unit; write e.g. mV, 1/ms or uF/cm**2")


def _is_number(node: ast.expr) -> bool:
    return isinstance(node.operand if isinstance(node, ast.UnaryOp) else node, ast.Constant)
