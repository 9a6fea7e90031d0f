"""Numbers with units, as people write them in an experiment file: ``20 ms``, ``1 kHz``, ``90 deg``.

The annotated types are for pydantic models; third parties use them for their own options.
"""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Annotated

from pydantic import BeforeValidator, PlainValidator, WithJsonSchema

from nrp_core.clock import NS_PER_MS, NS_PER_S
from nrp_core.errors import did_you_mean
from nrp_core.units import NUMBER, factor

TIME_UNITS = {unit: float(factor(unit, "s")) for unit in ("ns", "us", "ms", "s", "min", "h")}
_RATE = {unit: float(factor(unit, "Hz")) for unit in ("Hz", "kHz", "MHz")}
_LENGTH = {unit: float(factor(unit, "m")) for unit in ("mm", "cm", "m", "km")}
_ANGLE = {unit: float(factor(unit, "rad")) for unit in ("rad", "deg")}

_EXAMPLES = {"a time": "20 ms", "a rate": "20 Hz", "a length": "1.2 m", "an angle": "90 deg"}
_FRACTION = re.compile(r"\s*(\d+)\s*/\s*([1-9]\d*)\s*([A-Za-zµ]+)\s*\Z")
_SCRIPT_GRID_NS = Fraction(100_000)
_LARGEST = 1e30  # not a number in any unit
_LONGEST_NS = 2**63 - 1
"""The largest time in 64 bits: 292 years."""

_QUANTITY = re.compile(rf"\s*({NUMBER})\s*([A-Za-zµ°]*)\s*\Z")


def parse(value: object, units: dict[str, float], what: str, *, bare: str | None) -> Fraction | float:
    """Return a quantity in its base unit.

    Args:
        value: a number or a text such as ``20 ms``.
        units: the factor of each unit.
        what: the kind of quantity in messages, e.g. ``a time``.
        bare: the unit of a bare number; None: a unit is required.

    Raises:
        ValueError: the value cannot be read; the message lists valid values.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ValueError(f"{what} is a number with a unit ({', '.join(units)}), not {value!r}")
    match = _QUANTITY.match(str(value))
    if match is None:
        example = _EXAMPLES.get(what, f"20 {next(iter(units))}")
        raise ValueError(f"cannot read {value!r} as {what}; write e.g. '{example}'")
    number, unit = match.groups()
    if abs(float(number)) > _LARGEST:
        raise ValueError(f"{value!r} is too large for {what}")
    unit = unit.replace("µ", "u").replace("°", "deg") or ("" if float(number) else next(iter(units)))
    if not unit:
        if bare is None:
            raise ValueError(f"{what} needs a unit: '{number} ms' or '{number} s'?")
        unit = bare
    if unit not in units:
        raise ValueError(f"'{unit}' is not a unit of {what}{did_you_mean(unit, units)}")
    factor = units[unit]
    return Fraction(number) * Fraction(repr(factor)) if factor != units.get("deg") else float(number) * factor


def time_ns(value: object) -> int:
    """Read a time; it needs a unit, except for 0."""
    exact = parse(value, TIME_UNITS, "a time", bare=None) * NS_PER_S
    if exact != int(exact):
        raise ValueError(f"{value!r} is not a whole number of nanoseconds")
    if abs(int(exact)) > _LONGEST_NS:
        raise ValueError(f"{value!r} is longer than 292 years, the longest possible time")
    return int(exact)


class RoundedNs(int):
    """A period of the loop, ns, that was rounded from another one.

    Attributes:
        written: the other one, as it is written in the file.
    """

    written: str


def period_ns(value: object) -> int:
    """Read a period of the loop: a time, a rate (``60 Hz``) or a fraction of a time (``1/60 s``).

    A rate or fraction is rounded half up to 0.1 ms, the usual grid of brain scripts.

    Raises:
        ValueError: it cannot be read, or rounding changes it by more than 1 %.
    """
    fraction = _FRACTION.match(value) if isinstance(value, str) else None
    if fraction is None and not (isinstance(value, str) and value.endswith("Hz")):
        return _positive_ns(value)
    if fraction is None:
        rate = Fraction(parse(value, _RATE, "a rate", bare=None))
        if rate <= 0:
            raise ValueError(f"must be more than 0, not {value}")
        exact = NS_PER_S / rate
    else:
        exact = Fraction(fraction[1]) / Fraction(fraction[2]) * time_ns(f"1 {fraction[3]}")
    rounded = RoundedNs((exact + _SCRIPT_GRID_NS / 2) // _SCRIPT_GRID_NS * _SCRIPT_GRID_NS)
    if abs(rounded - exact) * 100 >= exact:
        near = f"{float(exact) / NS_PER_MS:.6g} ms, which is not within 1 % of a multiple of 0.1 ms"
        raise ValueError(f"'{value}' is {near}, the grid of brain scripts")
    rounded.written = str(value)
    return int(rounded) if rounded == exact else rounded


def length_m(value: object) -> float:
    """Read a length; a number without a unit is in metres."""
    return float(parse(value, _LENGTH, "a length", bare="m"))


def length_text(length_m: float) -> str:
    """Return a length for people: two decimals in metres, or millimetres below a tenth of one."""
    small = 0.0 < abs(length_m) < 0.1
    return f"{1e3 * length_m:.3g} mm" if small else f"{length_m:.2f} m"


def unit_of(value: object) -> str:
    """Return the kind of unit that is written behind a number: ``length``, ``angle``, or an empty text."""
    match = _QUANTITY.match(value) if isinstance(value, str) else None
    unit = match[2].replace("°", "deg") if match else ""
    return "length" if unit in _LENGTH else "angle" if unit in _ANGLE else ""


def _positive_ns(value: object) -> int:
    t_ns = time_ns(value)
    if t_ns <= 0:
        raise ValueError(f"must be more than 0, not {value}")
    return t_ns


def _not_negative_ns(value: object) -> int:
    t_ns = time_ns(value)
    if t_ns < 0:
        raise ValueError(f"must be 0 or more, not {value}")
    return t_ns


def _number(units: dict[str, float], what: str, bare: str) -> BeforeValidator:
    return BeforeValidator(lambda value: float(parse(value, units, what, bare=bare)))


def _schema(example: str, what: str) -> WithJsonSchema:
    return WithJsonSchema({"type": ["string", "number"], "description": what, "examples": [example]})


_TIME_SCHEMA = _schema("20 ms", "a time with its unit: ns, us, ms, s, min, h")

DurationNs = Annotated[int, BeforeValidator(_positive_ns), _TIME_SCHEMA]
"""A positive time, kept in nanoseconds."""
TimeNs = Annotated[int, BeforeValidator(_not_negative_ns), _TIME_SCHEMA]
"""A time of 0 or more, kept in nanoseconds."""
PeriodNs = Annotated[
    int, PlainValidator(period_ns), _schema("20 ms", "a time with its unit, a rate (60 Hz) or 1/60 s")
]
"""A period of the loop, kept in nanoseconds; see :func:`period_ns`."""
RateHz = Annotated[float, _number(_RATE, "a rate", "Hz"), _schema("30 Hz", "a rate: Hz, kHz")]
"""A rate, kept in Hz."""
LengthM = Annotated[float, BeforeValidator(length_m), _schema("1.2 m", "a length: mm, cm, m, km")]
"""A length, kept in metres."""
AngleRad = Annotated[float, _number(_ANGLE, "an angle", "rad"), _schema("90 deg", "an angle: rad, deg")]
"""An angle, kept in radians."""
Point = tuple[LengthM, LengthM]
"""A place on the ground, x and y, m."""
