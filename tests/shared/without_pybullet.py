"""Skip the tests that need PyBullet where it is not installed: it has no wheel for Python 3.12 and newer."""

from collections.abc import Generator
from importlib.util import find_spec
from typing import TypeVar

import pytest

Report = TypeVar("Report", pytest.CollectReport, pytest.TestReport)
REASON = "PyBullet is not installed: scripts/setup pybullet"
_ERROR = "No module named 'pybullet'"


def is_installed() -> bool:
    try:
        return find_spec("pybullet") is not None
    except ModuleNotFoundError:
        return False


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "pybullet: needs PyBullet, without a name or message that shows it")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip tests with the mark, and those with a parameter or class that names PyBullet."""
    if is_installed():
        return
    for item in items:
        names_it = "pybullet" in item.name.partition("[")[2] or "Pybullet" in item.nodeid
        if names_it or item.get_closest_marker("pybullet"):
            item.add_marker(pytest.mark.skip(reason=REASON))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Skip modules that cannot be imported without it."""
    report = yield
    return _skipped_without(report, collector)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Skip a test, or its fixtures, that failed because PyBullet is missing, also in another process."""
    report = yield
    return _skipped_without(report, item)


def _skipped_without(report: Report, node: pytest.Item | pytest.Collector) -> Report:
    if report.failed and _ERROR in str(report.longrepr) and not is_installed():
        report.outcome, report.longrepr = "skipped", (str(node.path), 0, f"Skipped: {REASON}")
    return report
