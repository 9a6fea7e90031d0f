"""Functions that fail on a camera image: their errors say that Gazebo did not draw it.

Thresholds of colours were tuned in Gazebo's light, and code often takes for granted that it finds something.
"""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from nrp_core.cle.engine import ClosedLoop
from nrp_core.dsl import TransferFunction
from nrp_core.experiment import Run
from nrp_core.world import Direction
from nrp_core.world.messages.sensor_msgs import Image

_GAZEBO = "gazebo"
_OF_CODE = (ImportError, NameError, OSError, SyntaxError)
"""Errors that no image causes, except that a variable was not set because nothing was found."""
_LIBRARIES = ("PIL", "cv2", "numpy", "scipy", "skimage")
"""Packages that compute with images."""


def explain_image_failures(run: Run) -> None:
    """Add a note to each error of a function that has received a camera image, unless Gazebo draws it."""
    if run.experiment.world.backend == _GAZEBO:
        return
    run.loop.hooks.after_step.append(_explain)


def _explain(loop: ClosedLoop) -> None:
    functions = {function.name: function for function in loop.functions}
    for failure in loop.failures:
        function = functions.get(failure.function)
        if failure.step == loop.steps and function is not None and _may_be_of_values(failure.error):
            for topic in _images_of(function):
                failure.error.add_note(f"the image of '{topic}' comes from another renderer than Gazebo's")


def _may_be_of_values(error: BaseException) -> bool:
    """Return whether other values in an image could have prevented an error."""
    if isinstance(error, AttributeError) and isinstance(error.obj, ModuleType):
        return False
    if not isinstance(error, Exception) or _is_of_another_library(error):
        return False
    return isinstance(error, UnboundLocalError) or not isinstance(error, _OF_CODE)


def _is_of_another_library(error: BaseException) -> bool:
    """Return whether a library raised an error that does not compute with images, such as one for plots."""
    *_, (frame, _line) = traceback.walk_tb(error.__traceback__)
    package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
    installed = {"site-packages", "dist-packages"}.intersection(Path(frame.f_code.co_filename).parts)
    return bool(installed) and package not in _LIBRARIES


def _images_of(function: TransferFunction) -> Iterator[str]:
    """Yield the topics of the cameras of which a function has received an image."""
    read = [name for name, mapping in function.mappings.items() if mapping.reads is not None]
    for name in read:
        topic: Any = function.adapters[name]
        if topic.info.type is Image and topic.info.direction is Direction.OUT and topic.value is not None:
            yield topic.name
