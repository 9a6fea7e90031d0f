"""The largest local error of what is integrated."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.equations.model import Variable
from nrp_core.brain.network.equations.units import AMPERE, NONE, SECOND, SIEMENS, VOLT

TOLERANCE: Final = 1e-7
"""The largest local error of a sub-step, in units of a variable's scale and value together."""
_SCALES: Final = {VOLT: 1e-3, AMPERE: 1e-9, SIEMENS: 1e-9, SECOND: 1e-3, NONE: 1e-2}
"""Sizes of variables by dimension, in SI units: mV, nA, nS, ms and percent."""


def scale_of(variable: Variable) -> float:
    """Return the size of a variable at which its error counts like that of larger values, in SI units."""
    return min(variable.unit.scale, _SCALES.get(variable.unit.dimension, variable.unit.scale))
