"""Run a suite of the kit and collect the result of every test."""

from __future__ import annotations

import os
import sys
from collections.abc import Collection
from pathlib import Path
from typing import Any

import pytest

from nrp_conformance.base import BackendTests
from nrp_conformance.report import KitResult, Outcome

ALONE = (
    "-c", os.devnull, "--rootdir", str(Path(__file__).parent), "-p", "no:cacheprovider",
    "-q", "--no-summary", "--pyargs", "nrp_conformance.suite",
)  # fmt: skip
"""Arguments for a pytest that runs only the suite, independent of the current folder."""

under_test: list[type[BackendTests]] = []
"""The last one is what :mod:`nrp_conformance.suite` shows to pytest."""


def run_tests(
    tests: type[BackendTests], only: Collection[str] = (), *, traceback: str = "short"
) -> list[KitResult]:
    """Run tests in a separate pytest run in this process, and return their results.

    Args:
        tests: the suite.
        only: the names of the tests to run; by default all.
        traceback: pytest's style of the tracebacks in the results; ``native`` is the quickest.
    """
    collector = ResultCollector(only)
    collected = ["-o", f"python_functions={' '.join(sorted(only))}"] if only else []  # the names begin so
    under_test.append(tests)
    sys.modules.pop(
        "nrp_conformance.suite", None
    )  # a module is imported once, but suites may run several times
    try:
        pytest.main([*ALONE, *collected, f"--tb={traceback}"], plugins=[collector])
    finally:
        under_test.pop()
    return collector.results


class ResultCollector:
    """A pytest plugin that collects results.

    Args:
        only: the names of the tests to run; by default all.
    """

    def __init__(self, only: Collection[str] = ()) -> None:
        self.results: list[KitResult] = []
        self._only = frozenset(only)
        self._failed: set[str] = set()

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = [
            item for item in items if not self._only or getattr(item, "originalname", "") in self._only
        ]
        for item in items:
            item.user_properties.append(("level", _level_of(item)))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" or report.outcome != "passed":
            self._add(report)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.results.append(KitResult("collection", "contract", Outcome.FAILED, report.longreprtext))

    def _add(self, report: pytest.TestReport) -> None:
        test = report.nodeid.partition("::")[2].partition("::")[2]
        if test in self._failed:
            return  # its teardown failed as well
        properties: dict[str, Any] = dict(report.user_properties)
        level = str(properties.pop("level"))
        outcome, reason = _outcome_of(report)
        if outcome is Outcome.FAILED:
            self._failed.add(test)
        self.results.append(KitResult(test, level, outcome, reason, round(report.duration, 4), properties))


def _level_of(item: pytest.Item) -> str:
    assert isinstance(item, pytest.Function)
    name, cls = item.originalname, item.cls
    assert cls is not None
    owner = next(base for base in reversed(cls.__mro__) if name in vars(base))
    return str(owner.level)


def _outcome_of(report: pytest.TestReport) -> tuple[Outcome, str]:
    if hasattr(report, "wasxfail"):
        outcome = Outcome.EXPECTED_TO_FAIL if report.skipped else Outcome.FAILED
        return outcome, report.wasxfail
    if report.skipped:
        assert isinstance(report.longrepr, tuple)  # a skip is a tuple: file, line, reason
        return Outcome.SKIPPED, report.longrepr[2].removeprefix("Skipped: ")
    if report.failed:
        return Outcome.FAILED, report.longreprtext
    return Outcome.PASSED, ""
