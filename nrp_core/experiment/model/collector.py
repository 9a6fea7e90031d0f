"""Collect mistakes of an experiment with their places, and continue."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from nrp_core.errors import BackendError, CapabilityError, ExperimentError
from nrp_core.experiment.model.tree import Key, Tree
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level, has_errors
from nrp_core.findings.error_codes import code_of

_MILD = {Code.NRP244: Level.WARNING}


@dataclass(frozen=True, slots=True)
class Omission:
    """A part that is left out if the experiment is not strict.

    Args:
        code: the code of the finding about it.
        kind: the kind of part, such as ``robot``.
        name: the name of the part; None: it does not have one.
    """

    code: Code
    kind: str
    name: str | None = None

    def finding(self, cause: Finding) -> Finding:
        """Return the finding about the part that is left out for a cause."""
        part = f"a {self.kind}" if self.name is None else f"the {self.kind} '{self.name}'"
        message = f"{part} is left out: {cause.message}"
        return replace(cause, code=self.code, message=message, level=Level.WARNING, subject=self.name)


class Collector:
    """Turns errors into findings.

    Args:
        source: the experiment as it was written, with the places.

    Attributes:
        source: the same.
        findings: the findings so far.
    """

    def __init__(self, source: Tree) -> None:
        self.source = source
        self._backend_error: BackendError | None = None
        self.findings: list[Finding] = []

    @contextmanager
    def during(
        self,
        code: Code,
        *keys: Key,
        level: Level = Level.ERROR,
        omission: Omission | None = None,
        always: bool = False,
    ) -> Iterator[None]:
        """Collect an error in this block instead of raising it.

        Args:
            code: the code of the finding, unless the class of the error has its own.
            keys: its place in the experiment; an error with a place keeps its own.
            level: its level.
            omission: the part that is left out on an error; None: an error is only reported.
            always: whether errors of every class get the code.
        """
        try:
            yield
        except InvalidExperimentError as error:
            self.findings += error.findings
        except (BackendError, CapabilityError, ExperimentError) as error:
            known = code if always else code_of(error, code)
            level = _MILD.get(known, level)
            if isinstance(error, ExperimentError) and error.path is not None:
                finding = replace(Finding.of(error, known), level=level)
            else:
                finding = self.source.place_of(*keys).finding(known, str(error), level)
            if omission is not None:
                finding = omission.finding(finding)
            self.findings.append(finding)
            if (
                finding.level is Level.ERROR
                and isinstance(error, BackendError)
                and self._backend_error is None
            ):
                located = self.source.place_of(*keys).finding(known, error.reason).as_error()
                self._backend_error = type(error)(str(located), remedy=error.remedy)

    def add(
        self,
        code: Code,
        message: str,
        *keys: Key,
        level: Level = Level.ERROR,
        subject: str | None = None,
    ) -> None:
        """Add a finding at a place of the experiment."""
        found = self.source.place_of(*keys).finding(code, message, level)
        self.findings.append(replace(found, subject=subject))

    def place(self, findings: Iterable[Finding], *keys: Key) -> None:
        """Add findings; those without a place get one of the experiment."""
        where = self.source.place_of(*keys)
        self.findings += (
            found
            if found.path is not None
            else replace(found, path=where.path, line=where.line, column=where.column)
            for found in findings
        )

    def raise_errors(self) -> None:
        """Raise the mistakes that prevent a run, if there are any.

        Raises:
            BackendError: a backend is missing or broken.
            InvalidExperimentError: anything else is wrong; it carries all findings.
        """
        if self._backend_error is not None:
            raise self._backend_error
        if has_errors(self.findings):
            raise InvalidExperimentError(self.findings)
