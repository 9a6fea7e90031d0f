"""Objects that take part in a run: observers that any program registers, and makers of parts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Generic, TypeVar

import numpy.typing as npt

from nrp_core.dsl.functions import TransferFunction

RunType = TypeVar("RunType", contravariant=True)
"""The class of runs, which stands above this module."""


class RunObserver(Generic[RunType]):
    """Observes a run while it is in :attr:`.Run.observers`; a subclass overrides the methods that it needs.

    All are called in the thread of the run, in the order of the list; :meth:`closing` in the opposite order.
    An exception ends the run.
    """

    def after_step(self, run: RunType) -> None:
        """Observe a step, when its events have happened and its criteria are decided."""

    def functions_changed(
        self, run: RunType, added: Sequence[TransferFunction | Path], removed: Sequence[str]
    ) -> None:
        """Observe a change of transfer functions: functions or their files, and the names of removed ones."""

    def function_activated(self, run: RunType, name: str, active: bool) -> None:
        """Observe that a transfer function was activated or deactivated."""

    def part_reset(self, run: RunType, part: str) -> None:
        """Observe the reset of one part, without a change of the time: ``brain``, ``robot`` or ``world``."""

    def parameters_changed(
        self, run: RunType, population: str, values: Mapping[str, float], cells: Sequence[int] | None
    ) -> None:
        """Observe a change of parameters of cells from outside; ``cells`` is None for a whole population."""

    def weights_changed(self, run: RunType, projection: str, weights: npt.ArrayLike, relative: bool) -> None:
        """Observe a change of weights from outside; if ``relative``, by factors."""

    def closing(self, run: RunType) -> None:
        """Observe the end of the run, before its engines are released."""


class StepObserver(RunObserver[RunType]):
    """Calls a function after each step.

    Args:
        function: called with the run.
    """

    def __init__(self, function: Callable[[RunType], object]) -> None:
        self._function = function

    def after_step(self, run: RunType) -> None:
        self._function(run)


class Participant(ABC, Generic[RunType]):
    """A maker of parts that also takes part in the runs of its experiment."""

    @property
    @abstractmethod
    def can_be_saved(self) -> bool:
        """Whether a snapshot of the run contains all of its state."""

    @abstractmethod
    def begin(self, run: RunType) -> None:
        """Take part in a run that is about to start, through the hooks of its loop."""
