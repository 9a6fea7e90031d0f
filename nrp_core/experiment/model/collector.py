"""Collect what is wrong with an experiment, at the places where it is written, and go on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from nrp_core.errors import (
    BackendError,
    CapabilityError,
    ExperimentError,
    NeuronSelectionError,
    SlowScriptError,
    TopicError,
)
from nrp_core.experiment.model.tree import Key, Tree
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level, has_errors

_CODES = {
    BackendError: Code.NRP205,
    NeuronSelectionError: Code.NRP211,
    TopicError: Code.NRP212,
    CapabilityError: Code.NRP216,
    SlowScriptError: Code.NRP244,
}
_MILD = {Code.NRP244: Level.WARNING}


class Collector:
    """Turns errors into findings.

    Args:
        source: the experiment as it was written, which knows the places.

    Attributes:
        source: the same.
        findings: what was found so far.
    """

    def __init__(self, source: Tree) -> None:
        self.source = source
        self._backend_error: BackendError | None = None
        self.findings: list[Finding] = []

    @contextmanager
    def during(self, code: Code, *keys: Key, level: Level = Level.ERROR) -> Iterator[None]:
        """Collect an error in this block instead of letting it through.

        Args:
            code: what kind of finding it is, unless the class of the error says more.
            keys: where in the experiment it belongs; an error with a place of its own keeps it.
            level: how bad it is.
        """
        try:
            yield
        except InvalidExperimentError as error:
            self.findings += error.findings
        except (BackendError, CapabilityError, ExperimentError) as error:
            known = next((known for kind, known in _CODES.items() if isinstance(error, kind)), code)
            level = _MILD.get(known, level)
            if isinstance(error, ExperimentError) and error.path is not None:
                self.findings.append(replace(Finding.of(error, known), level=level))
                return
            finding = self.source.place_of(*keys).finding(known, str(error), level)
            self.findings.append(finding)
            if level is Level.ERROR and isinstance(error, BackendError) and self._backend_error is None:
                self._backend_error = type(error)(str(finding.as_error()))

    def add(self, code: Code, message: str, *keys: Key, level: Level = Level.ERROR) -> None:
        """Add a finding at a place of the experiment."""
        self.findings.append(self.source.place_of(*keys).finding(code, message, level))

    def raise_errors(self) -> None:
        """Raise what keeps the experiment from running, if anything does.

        Raises:
            BackendError: a backend is missing or broken.
            InvalidExperimentError: anything else is wrong; it carries all findings.
        """
        if self._backend_error is not None:
            raise self._backend_error
        if has_errors(self.findings):
            raise InvalidExperimentError(self.findings)
