"""Names of links and joints in a scene, as Gazebo scopes them.

A full name is the path of models and then the part, ``arm::gripper::finger``; its first model is one of the
scene, and the names of models nested in that belong to the name of the part, ``gripper::finger``. A name in
its own model (``gripper::finger``, ``finger``) is enough if no other part has it. ``/`` may replace ``::``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.scene.model import Model

SCOPE = "::"


def split_name(models: Iterable[Model], name: str) -> tuple[Model | None, str]:
    """Return the model, of the longest name that begins this one, and the part; None for a part alone."""
    path = name.replace("/", SCOPE)
    owners = [model for model in models if path.startswith(model.name + SCOPE)]
    owner = max(owners, key=lambda model: len(model.name), default=None)
    return owner, path if owner is None else path.removeprefix(owner.name + SCOPE)


def find_link(models: Sequence[Model], name: str) -> tuple[Model, str]:
    """Return the model and the link that a name stands for.

    Raises:
        SceneError: no link has the name, or several have it.
    """
    return _find(models, name, "link", lambda model: [link.name for link in model.links])


def find_joint(models: Sequence[Model], name: str) -> tuple[Model, str]:
    """Return the model and the coordinate of a joint that a name stands for.

    Raises:
        SceneError: no joint has the name, or several have it.
    """
    return _find(models, name, "joint", lambda model: [one for j in model.joints for one in j.coordinates])


def _find(
    models: Sequence[Model], name: str, kind: str, parts: Callable[[Model], list[str]]
) -> tuple[Model, str]:
    owner, part = split_name(models, name)
    owner = models[0] if owner is None and len(models) == 1 else owner
    known = [(model, parts(model)) for model in ([owner] if owner else models)]
    found = [(model, one) for model, names in known for one in _matching(part, names)]
    if len(found) == 1:
        return found[0]
    many = "more than one" if found else "no"
    if owner is None:
        full = [model.name + SCOPE + one for model, names in known for one in names]
        raise SceneError(f"{many} model has {kind} '{name}'; name it model::{kind}{did_you_mean(name, full)}")
    raise SceneError(f"model '{owner.name}' has {many} {kind} '{part}'{did_you_mean(part, parts(owner))}")


def _matching(part: str, names: Sequence[str]) -> list[str]:
    """Return the parts of a model with a name; if there is none, those of nested models."""
    exact = [name for name in names if name.replace("/", SCOPE) == part]
    return exact or [name for name in names if name.rpartition(SCOPE)[2] == part]
