"""NEST's models of cells that have no standard cell of PyNN: as equations, with NEST's names and units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from nrp_pynest.equations.glif import GLIF
from nrp_pynest.equations.hill_tononi import HILL_TONONI
from nrp_pynest.equations.hodgkin_huxley import HODGKIN_HUXLEY
from nrp_pynest.equations.integrate_and_fire import INTEGRATE_AND_FIRE
from nrp_pynest.equations.model import EquationModel

EQUATIONS: Final[Mapping[str, EquationModel]] = {
    **HODGKIN_HUXLEY, **INTEGRATE_AND_FIRE, **GLIF, **HILL_TONONI,
}  # fmt: skip
"""The models by NEST's names."""
