"""A model of NEST as equations, whose lists of parameters decide on the number of its variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.network.equations.cell import CellEquations

Lengths = Mapping[str, int]
"""The number of elements of each parameter that is a list."""
Values = Mapping[str, FloatArray]
"""A value for each cell by name; the elements of a list ``tau`` are ``tau_1``, ``tau_2``, ..."""


def nothing_more(_values: Values) -> Values:
    """Return no derived values."""
    return {}


@dataclass(frozen=True)
class EquationModel:
    """A model as equations.

    Args:
        cell_of: returns the equations for the lengths of its lists; an injected current is the parameter
            ``i_offset``, which is NEST's ``I_e``.
        defaults: the defaults of NEST's parameters; those that are lists are tuples.
        initial: the state at time 0, as far as it is not 0.
        recordables: the variables that a multimeter can record.
        ports: the list whose elements are the receptors, numbered from 1; empty if the sign of a weight
            chooses the receptor.
        n_ports: the number of receptors of a model without such a list.
        derive: returns further parameters and initial values, from those of the cells.
    """

    cell_of: Callable[[Lengths], CellEquations]
    defaults: Mapping[str, Any]
    initial: Mapping[str, float] = field(default_factory=dict)
    recordables: tuple[str, ...] = ("V_m",)
    ports: str = ""
    n_ports: int = 0
    derive: Callable[[Values], Values] = nothing_more

    @property
    def lists(self) -> tuple[str, ...]:
        """The parameters that are lists."""
        return tuple(name for name, value in self.defaults.items() if isinstance(value, tuple))

    @property
    def numbers(self) -> dict[str, float]:
        """The defaults of the parameters that are numbers, by their names in the equations."""
        return {
            "i_offset" if name == "I_e" else name: float(value)
            for name, value in self.defaults.items()
            if not isinstance(value, tuple)
        }


def numbered(n: int) -> list[str]:
    """Return the endings of the names of n receptors."""
    return [str(k + 1) for k in range(n)]


def summed(prefix: str, n: int, unit: str) -> str:
    """Return the text of a sum over numbered names; 0 in a unit if there are none."""
    return " + ".join(f"{prefix}_{k}" for k in numbered(n)) or f"0.0*{unit}"


def units_of(names: str, unit: str) -> dict[str, str]:
    """Return one unit for several names, which are separated by spaces."""
    return dict.fromkeys(names.split(), unit)


def unit_peak(decay_ms: FloatArray, rise_ms: FloatArray) -> FloatArray:
    """Return the factor (1/ms) by which a difference of two exponentials rises to 1.

    Equal time constants give the alpha function.
    """
    fast, slow = np.minimum(decay_ms, rise_ms), np.maximum(decay_ms, rise_ms)
    slow = np.where(slow - fast < 1e-6 * slow, fast * (1.0 + 1e-6), slow)
    peak_ms = slow * fast / (slow - fast) * np.log(slow / fast)
    return np.asarray((1.0 / fast - 1.0 / slow) / (np.exp(-peak_ms / slow) - np.exp(-peak_ms / fast)))
