"""Scenes that consist of one MJCF file keep its time step, integrator and solver."""

from __future__ import annotations

from nrp_core.clock import NS_PER_S, dividing_step
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.origin import Native

FILE = "file"
"""The element with the settings of the file that a model was converted from."""
SETTINGS = ("cone", "impratio", "integrator", "solver", "timestep")
"""Its attributes."""


def settings_of(model: Model) -> Native | None:
    """Return the settings of the MJCF file of a model; None for files of other formats."""
    return next((each for each in model.native if each.full_tag == f"mujoco:{FILE}"), None)


def settings_of_scene(scene: Scene) -> Native | None:
    """Return the settings of the only MJCF file of a scene; None for other scenes."""
    if len({model.source and model.source.file for model in scene.models}) != 1:
        return None
    return next(filter(None, map(settings_of, scene.models)), None)


def step_of(settings: Native, period_ns: int | None) -> int:
    """Return the time step of a file, ns, or one below that divides the step of the loop."""
    own_ns = max(round(float(settings.attribute("timestep") or 0) * NS_PER_S), 1)
    return own_ns if period_ns is None else dividing_step(own_ns, period_ns)
