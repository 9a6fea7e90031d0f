"""The cells of SONATA's cell models, by schema: ``pynn:`` for PyNN's standard cells, ``nest:`` for NEST's."""

from __future__ import annotations

import difflib
from collections.abc import Mapping

from nrp_core.brain.network.cells import CELLS
from nrp_core.brain.network.nest_models import NEST_CELLS, CellModel
from nrp_core.errors import CapabilityError

_PYNN = {name: CellModel(name, {}) for name in CELLS}
_SCHEMAS: Mapping[str, Mapping[str, CellModel]] = {"pynn": _PYNN, "nest": NEST_CELLS}


def model_of(owner: str, model_type: str, template: str) -> CellModel:
    """Return the model of a type of point neurons.

    Args:
        owner: the owner of the model, for the message.
        model_type: SONATA's model type.
        template: ``schema:resource``.

    Raises:
        CapabilityError: the model is not supported; the message names the nearest.
    """
    schema, _, resource = template.partition(":")
    if model_type not in ("point_neuron", "point_process"):
        raise CapabilityError(
            f"{owner} is of model_type '{model_type}'; supported are point_neuron and virtual, and "
            "the nearest cell with channels is pynn:HH_cond_exp"
        )
    models = _SCHEMAS.get(schema.lower())
    if models is None:
        choices = [f"{known}:{name}" for known, names in _SCHEMAS.items() for name in names]
        nearest = difflib.get_close_matches(template, choices, 1, 0.0)[0]
        raise CapabilityError(
            f"{owner} is of model '{template}', which is not supported; "
            f"the nearest supported model: {nearest}"
        )
    if resource not in models:
        nearest = f"{schema}:{difflib.get_close_matches(resource, list(models), 1, 0.0)[0]}"
        nearest = "pynn:HH_cond_exp" if resource.startswith(("hh_", "HH_")) else nearest
        raise CapabilityError(
            f"{owner} is of model '{template}', which is not supported; "
            f"the nearest supported model: {nearest}"
        )
    return models[resource]
