"""The arithmetic of the machine: s16.15 numbers as integers, products that floor, sums that wrap.

State and input are s16.15, decays u0.32. Every function takes and returns raw bits as plain integers, and all
intermediates fit 64 bits, so the code is exact as Python and compiled. The operations are those of compiled
fixed-point C (ISO/IEC TR 18037) on the machine's ARM cores: without rounding to nearest and without
saturation (Mikaitis 2020, arXiv:2001.01496).
"""

from __future__ import annotations

from nrp_core._support.jit import jit

ONE = 1 << 15
"""1.0 in s16.15."""
HALF = 1 << 14
"""0.5 in s16.15."""
LARGEST = (1 << 31) - 1
"""The largest s16.15 number, 65535.99997."""
SMALLEST = -(1 << 31)
"""The smallest s16.15 number, -65536."""
FRACTION_LARGEST = (1 << 32) - 1
"""The largest u0.32 number; 1.0 does not fit."""


@jit
def wrap(value: int) -> int:
    """Keep the low 32 bits as a signed number."""
    return ((value + 0x80000000) & 0xFFFFFFFF) - 0x80000000


@jit
def mul(a: int, b: int) -> int:
    """Multiply two s16.15 numbers, toward minus infinity."""
    return wrap((a * b) >> 15)


@jit
def scale(a: int, fraction: int) -> int:
    """Multiply an s16.15 number by a u0.32 fraction, toward minus infinity."""
    return (a * fraction) >> 32


@jit
def div(a: int, b: int) -> int:
    """Divide two s16.15 numbers, ``a >= 0``, truncating.

    The machine divides unsigned, where a negative divisor is larger than any dividend.
    """
    return wrap((a << 15) // b) if b > 0 else 0


@jit
def ceiling(a: int) -> int:
    """Round an s16.15 number up to an integer."""
    return -(-a >> 15)


@jit
def clamp(value: int) -> int:
    """Return the nearest s16.15 number (used only if the machine does not define the rounding)."""
    return min(max(value, SMALLEST), LARGEST)
