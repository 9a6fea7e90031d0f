"""Networks for the spinnaker backend, made of few words."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from nrp_brain_spinnaker import SpinnakerBackend, SpinnakerOptions

from nrp_core.brain.interface import Brain
from nrp_core.network.cells import CELLS
from nrp_core.network.data import Network, Population, Projection

_REFRACTORY_MS = 2.0


@pytest.fixture
def cells(cells: Callable[..., Population]) -> Callable[..., Population]:
    """Make cells with PyNN's defaults, refractory for whole steps; ``v0`` and ``u0`` are initial values."""

    def make(label: str, cell_type: str, size: int = 1, **given: float) -> Population:
        izhikevich = cell_type.startswith(("Izhikevich", "IZK"))
        defaults = {"v0": -70.0, "u0": -14.0} if izhikevich else {"tau_refrac": _REFRACTORY_MS}
        if cell_type == "HH_cond_exp":
            defaults = {}
        values = defaults | given
        initial = {name: values.pop(f"{name}0") for name in "vu" if f"{name}0" in values}
        standard = cells(label, "Izhikevich" if izhikevich else cell_type, size, initial, **values)
        if "v" not in initial:
            rest = standard.parameters.get("v_rest", standard.parameters.get("e_rev_leak"))
            standard = replace(standard, initial_values={**standard.initial_values, "v": rest})
        own = {name: np.full(size, float(each.default)) for name, each in CELLS[cell_type].parameters.items()}
        return replace(standard, cell_type=cell_type, parameters={**own, **standard.parameters})

    return make


@pytest.fixture
def open_brain() -> Callable[..., Brain]:
    """Open a network of populations and projections; options as in an experiment file."""

    def make(*parts: Population | Projection, seed: int = 1, **options: object) -> Brain:
        populations = {part.label: part for part in parts if isinstance(part, Population)}
        projections = tuple(part for part in parts if isinstance(part, Projection))
        chosen = SpinnakerOptions.model_validate(options)
        return SpinnakerBackend().open(Network(populations, projections), seed=seed, options=chosen)

    return make
