"""Every error the platform raises on purpose.

Each is also the matching builtin, so ``except ValueError`` works where a caller expects it::

    NrpError
    ├── BackendError
    │   ├── UnknownBackendError       (LookupError)   no installed distribution provides the name
    │   ├── DuplicateBackendError     (LookupError)   two distributions claim one name
    │   ├── BackendLoadError          (ImportError)   found, but it does not import or open
    │   └── IncompatibleBackendError  (ImportError)   written for another interface version
    ├── ExperimentError               (ValueError)    a mistake of the user; carries path, line, column
    │   ├── TimestepError                             time steps that do not divide
    │   ├── TopicError                (LookupError)   unknown topic, or wrong type or direction
    │   ├── NeuronSelectionError      (LookupError)   population unknown or index out of range
    │   ├── UnknownNameError          (KeyError)      a result has no value of this name
    │   ├── ArgumentError             (TypeError)     a function is given an argument of the wrong kind
    │   ├── TransferFunctionError                     a transfer function is declared wrongly
    │   │   ├── TriggerError                          its trigger brings no messages or spikes
    │   │   └── OutsideFolderError                    a file of a recorder lies outside the folder of the run
    │   ├── NetworkError                              a network contradicts itself
    │   │   ├── SlowScriptError                       a brain script takes longer than a check may last
    │   │   ├── UncheckedScriptError                  a brain script cannot be confined, and is not executed
    │   │   └── EndlessScriptError                    a brain script takes longer than the experiment allows
    │   ├── ParameterError                            a declaration of a parameter contradicts another
    │   └── SceneError                                a robot or room file cannot be used
    ├── CapabilityError               (NotImplementedError)  the backend lacks a capability
    ├── SimulationError               (RuntimeError)  a failure while running; carries t_ns
    │   ├── DivergedError             (ArithmeticError)  NaN or infinity from an engine
    │   ├── TransferFunctionRaisedError               a transfer function raised
    │   ├── RecordingError                            a recording cannot be written
    │   └── SnapshotError                             a snapshot does not fit
    ├── UnreadableError               (LookupError)   a value that is known only when a file is executed
    └── LifecycleError                (RuntimeError)  a call out of order, e.g. on a closed simulation
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple


class NrpError(Exception):
    """Base of every error raised on purpose by the platform."""


class UnreadableError(NrpError, LookupError):
    """A value that is only known when the file is executed."""


class BackendError(NrpError):
    """A brain or world backend cannot be used.

    Args:
        reason: why.
        remedy: the command that would make it available; empty if unknown.
    """

    def __init__(self, reason: str, *, remedy: str = "") -> None:
        super().__init__(f"{reason}; try: {remedy}" if remedy else reason)
        self.reason = reason
        self.remedy = remedy


class UnknownBackendError(BackendError, LookupError):
    """No installed distribution provides the requested backend."""


class DuplicateBackendError(BackendError, LookupError):
    """Two installed distributions provide a backend under the same name."""


class BackendLoadError(BackendError, ImportError):
    """An installed backend does not import or open."""


class IncompatibleBackendError(BackendError, ImportError):
    """A backend was written for another version of the interface."""


class Instead(NamedTuple):
    """An unknown name, and the name that was probably meant."""

    written: str
    meant: str


class Hint(str):
    """The end of a message about a misspelt name.

    Attributes:
        instead: the valid name that is closest to the misspelt one, if any is close.
    """

    __slots__ = ("instead",)
    instead: Instead | None

    def __new__(cls, text: str = "", instead: Instead | None = None) -> Hint:
        hint = super().__new__(cls, text)
        hint.instead = instead
        return hint

    def __reduce__(self) -> tuple[type[Hint], tuple[str, Instead | None]]:
        return type(self), (str(self), self.instead)


class ExperimentError(NrpError, ValueError):
    """Something the user wrote is wrong.

    Args:
        message: the mistake and the valid alternatives, in one or a few sentences.
        path: the file, if known.
        line: the 1-based line, if known.
        column: the 1-based column, if known.
        subject: the name of the object concerned, such as a population, if it has one.
        instead: a name in the line, and its replacement, if that corrects the mistake.
    """

    def __init__(
        self,
        message: str,
        *,
        path: Path | str | None = None,
        line: int | None = None,
        column: int | None = None,
        subject: str | None = None,
        instead: Instead | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.path = None if path is None else Path(path)
        self.line = line
        self.column = column
        self.subject = subject
        self.instead = instead

    @property
    def location(self) -> str:
        """``file:line:column`` as far as known, or an empty string."""
        if self.path is None:
            return ""
        parts = (str(self.path), self.line, self.column)
        return ":".join(str(part) for part in parts if part is not None)

    def __str__(self) -> str:
        return f"{self.location}: {self.message}" if self.path is not None else self.message


class TimestepError(ExperimentError):
    """Time steps that do not divide each other."""


class TopicError(ExperimentError, LookupError):
    """A topic that does not exist, or has another type or direction."""


class NeuronSelectionError(ExperimentError, LookupError):
    """A population that does not exist or an index outside it."""


class UnknownNameError(ExperimentError, KeyError):
    """A name in a result that does not exist."""


class ArgumentError(ExperimentError, TypeError):
    """A function is given an argument of the wrong kind, or one that it does not have."""


class TransferFunctionError(ExperimentError):
    """A transfer function is declared wrongly (found before the first step)."""


class TriggerError(TransferFunctionError):
    """A transfer function is to be triggered by something that is neither a topic nor a spike recorder."""


class OutsideFolderError(TransferFunctionError):
    """A recorder tried to write a file outside the folder of its run."""


class NetworkError(ExperimentError):
    """A neural network that contradicts itself or physics."""


class SlowScriptError(NetworkError):
    """A brain script takes longer than a check may last."""


class UncheckedScriptError(NetworkError):
    """A brain script was not executed by a check, because the system cannot confine it."""


class EndlessScriptError(NetworkError):
    """A brain script takes longer than the experiment allows."""


class ParameterError(ExperimentError):
    """A declaration of a parameter that contradicts itself or another one."""


class SceneError(ExperimentError):
    """A robot or room description that cannot be used."""


class CapabilityError(NrpError, NotImplementedError):
    """The backend declares that it lacks the requested capability."""


class SimulationError(NrpError, RuntimeError):
    """Something failed while the simulation ran.

    Args:
        message: the failure.
        t_ns: simulated time of the failure in nanoseconds, if known.
    """

    def __init__(self, message: str, *, t_ns: int | None = None) -> None:
        super().__init__(message)
        self.t_ns = t_ns


class DivergedError(SimulationError, ArithmeticError):
    """An engine produced NaN or infinity."""


class TransferFunctionRaisedError(SimulationError):
    """A transfer function raised or returned something its topic cannot carry."""


class RecordingError(SimulationError):
    """A recording cannot be written to the disk."""


class SnapshotError(SimulationError):
    """A snapshot belongs to another model, backend or set of options."""


class LifecycleError(NrpError, RuntimeError):
    """A call came out of order, such as stepping a closed simulation."""


_MOST_NAMES, _NEAREST = 12, 6
"""At most this many names are listed."""


def did_you_mean(name: object, valid: Iterable[str], *, cutoff: float = 0.6) -> Hint:
    """Return a hint for a misspelt name.

    Args:
        name: the misspelt name, or whatever was given in its place.
        valid: the valid ones.
        cutoff: how similar one must be to be proposed, 0 to 1.

    Returns:
        ``"; did you mean 'x'?"`` if one valid name is close, otherwise ``"; valid: a, b, c"`` with the most
        similar names.
    """
    names, text = sorted(set(valid)), str(name)
    close = [one for one in names if one.lower() == text.lower()]
    close = close or [one for one in names if sorted(one) == sorted(text)]  # letters exchanged
    close = close or difflib.get_close_matches(text, names, n=1, cutoff=cutoff)
    if close:
        return Hint(f"; did you mean '{close[0]}'?", Instead(text, close[0]))
    if len(names) > _MOST_NAMES:
        like = difflib.get_close_matches(text, names, n=_NEAREST, cutoff=0.0)
        return Hint(f"; valid: {', '.join(sorted(like))} and {len(names) - len(like)} more")
    return Hint(f"; valid: {', '.join(names)}" if names else "; there are none")


def hint_if_close(name: str, valid: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` if one valid name is very close; empty otherwise.

    It is for names that may well be right elsewhere, where a list of all others is no help.
    """
    hint = did_you_mean(name, valid, cutoff=0.8)
    return hint if hint.instead else ""


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return the valid name that is most similar to an unknown one, and all valid names.

    Returns:
        ``"the nearest is x, of a, b, x"``, ``"there is only x"``, or ``"there are none"``.
    """
    names = sorted(set(valid))
    if len(names) == 1:
        return f"there is only {names[0]}"
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.0)
    return f"the nearest is {close[0]}, of {', '.join(names)}" if close else "there are none"
