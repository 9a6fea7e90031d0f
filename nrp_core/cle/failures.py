"""Reports of transfer functions that raised or did not return."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nrp_core.cle.time_limit import TimeLimitExceeded
from nrp_core.clock import seconds
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.parameters.source_line import line_in
from nrp_core.errors import ExperimentError, TransferFunctionRaisedError


@dataclass(frozen=True, slots=True)
class Failure:
    """A transfer function that raised, did not return, or returned what its topic cannot carry.

    Args:
        function: its name.
        path: its file.
        line: the line; for a function that did not return, the line that was running.
        step: number of the step, starting at 1.
        t_ns: the time that brain and world had reached.
        error: the exception.
        inputs: the values of its parameters.
    """

    function: str
    path: Path
    line: int
    step: int
    t_ns: int
    error: BaseException
    inputs: dict[str, str]

    @classmethod
    def of(cls, function: TransferFunction, error: BaseException, *, step: int, t_ns: int) -> Failure:
        """Describe what happened."""
        path = function.place.path
        line = line_in(error.__traceback__, path) or function.place.line
        return cls(function.name, Path(path), line, step, t_ns, error, function.inputs())

    def __str__(self) -> str:
        return "\n".join([
            f"{self.path}:{self.line}: transfer function '{self.function}' {self.reason}",
            f"  in step {self.step}, at {seconds(self.t_ns):g} s{', with' if self.inputs else ''}",
            *(f"    {name}: {seen}" for name, seen in self.inputs.items()),
        ])  # fmt: skip

    @property
    def reason(self) -> str:
        """The failure as the rest of a sentence that begins with the function."""
        error = self.error
        message = error.message if isinstance(error, ExperimentError) else str(error)
        if isinstance(error, TimeLimitExceeded):
            return message
        return f"raised {type(error).__name__}{': ' if message else ''}{message}"

    def to_error(self) -> TransferFunctionRaisedError:
        """Return the error that stops a run."""
        return TransferFunctionRaisedError(str(self), t_ns=self.t_ns)
