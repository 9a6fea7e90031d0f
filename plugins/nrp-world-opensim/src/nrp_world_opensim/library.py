"""OpenSim without its log file, and the models that it reads."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import opensim
from nrp_core.errors import SceneError
from nrp_core.world import FloatArray, Pose, Vector

_PLACES = re.compile(
    r"std::exception in '.*?': |\s*\(?Thrown at [^\n]*|SimTK Exception thrown at \S+:\d+:"
    r"|Error detected by Simbody method [\w:]+\(\):|\(Required condition .*?\)|[\w ]*apparently because:"
)
"""The parts of a message about OpenSim's own sources."""

opensim.Logger.removeFileSink()  # otherwise it writes opensim.log into the working folder
opensim.Logger.setLevelString("Critical")


def open_model(path: Path) -> Any:
    """Return the model in a file, finalised but without a state.

    Raises:
        SceneError: OpenSim cannot read it, or it has a controller that sets its excitations.
    """
    try:
        model = opensim.Model(str(path))
        model.finalizeFromProperties()
    except RuntimeError as error:
        raise SceneError(f"OpenSim cannot read this: {reason(error)}", path=path) from None
    for controller in elements(model.getControllerSet()):
        if controller.isEnabled():
            raise SceneError(
                f"the controller '{controller.getName()}' of the model '{model.getName()}' sets excitations, "
                "which the commands of an experiment set here; remove it from the file",
                path=path,
            )
    return model


def initial_state(model: Any, path: Path) -> Any:
    """Return the assembled state at time 0 in which the fibres of muscles and their tendons are in balance.

    Raises:
        SceneError: the model cannot be assembled.
    """
    try:
        state = model.initSystem()
    except RuntimeError as error:
        raise SceneError(
            f"OpenSim cannot build the model '{model.getName()}': {reason(error)}", path=path
        ) from None
    try:
        model.equilibrateMuscles(state)
    except RuntimeError as error:
        raise SceneError(
            f"the muscles of '{model.getName()}' have no balance at its initial coordinates: {reason(error)}",
            path=path,
        ) from None
    return state


def reason(error: Exception) -> str:
    """Return what an error of OpenSim says, without the places in its sources."""
    return " ".join(_PLACES.sub(" ", str(error)).split()).rstrip(".")


def elements(collection: Any) -> Iterator[Any]:
    """Yield the elements of one of OpenSim's sets."""
    for index in range(collection.getSize()):
        yield collection.get(index)


def array(vector: Any) -> FloatArray:
    """Return a copy of a vector of OpenSim, shape ``(n,)``."""
    return np.array(vector.to_numpy(), float)


def vector_of(values: FloatArray) -> Any:
    """Return a vector of OpenSim."""
    return opensim.Vector.createFromMat(np.ascontiguousarray(values, float))


def triple(vector: Any) -> Vector:
    """Return a vector of three numbers."""
    return float(vector.get(0)), float(vector.get(1)), float(vector.get(2))


def pose_of(transform: Any) -> Pose:
    """Return a transform of OpenSim as a pose."""
    turn = transform.R().convertRotationToQuaternion()
    w, x, y, z = (float(turn.get(index)) for index in range(4))
    return Pose(triple(transform.p()), (x, y, z, w))


def upright(model: Any) -> Pose:
    """Return the rotation that takes the axes of a file, where y usually points up, to those of a world."""
    gravity = np.array(triple(model.getGravity()))
    strength = float(np.linalg.norm(gravity))
    up = -gravity / strength if strength else np.array((0.0, 1.0, 0.0))
    x, y, z = up.tolist()
    return Pose.pointing((x, y, z)).inverse()
