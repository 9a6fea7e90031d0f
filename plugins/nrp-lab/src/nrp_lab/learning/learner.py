"""Learners: the file of one, and those that are installed."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

from pydantic import Field

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import Name, Section, read_form
from nrp_core.paths import ExistingFile
from nrp_core.registry import Registry

FILE = "learner.yaml"
LEARNERS: Registry[ModuleType] = Registry("nrp_core.learners", "learner")
"""The packages of learners, each with a file ``learner.yaml``."""


class Learner(Section):
    """A brain, and the transfer functions that teach it, for any task.

    The brain script and the functions declare the parameters ``observed`` and ``actions``, the number of
    observed quantities and of actions. The functions subscribe to ``/task/observation``
    (``std_msgs/Float64MultiArray``: from -1 to 1; empty between episodes), ``/task/reward``
    (``std_msgs/Float64``, of the last step), ``/task/failed`` (``std_msgs/Bool``: the last step ended the
    episode, not its time limit) and ``/task/learning`` (``std_msgs/Bool``: weights may change), and publish
    ``/task/action`` (``std_msgs/Int32``, from 0).
    """

    model: ExistingFile
    """The brain script."""
    transfer_functions: tuple[ExistingFile, ...]
    """Files with transfer functions."""
    brain_parameters: dict[Name, int | float] = Field(default_factory=dict)
    """Further parameters of the brain script."""
    function_parameters: dict[Name, int | float] = Field(default_factory=dict)
    """Further parameters of the functions."""


def find_learner(name: str | Path) -> Path:
    """Return the file of a learner.

    Args:
        name: an installed learner, a file, or a folder with a file ``learner.yaml``.

    Raises:
        ExperimentError: none was found.
    """
    if name in LEARNERS.names():
        (folder,) = LEARNERS.load(str(name)).__path__
        return Path(folder) / FILE
    path = Path(name).expanduser()
    path = path / FILE if path.is_dir() else path
    if path.is_file():
        return path.resolve()
    raise ExperimentError(f"there is no learner '{name}'{did_you_mean(str(name), LEARNERS.names())}")


def read_learner(path: Path) -> Learner:
    """Read the file of a learner.

    Raises:
        InvalidExperimentError: it is not valid.
    """
    return read_form(path, Learner, "a learner")[0]
