"""How many cases of a test are run: few, and the same in each run, so that a run can be repeated."""

from collections import Counter

import pytest
from hypothesis import settings

# busy machines: no test is timed
settings.register_profile("short", deadline=None, max_examples=15, derandomize=True)
settings.register_profile("thorough", deadline=None)  # before a release: --hypothesis-profile thorough
settings.load_profile("short")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "one_of(n): of its many cases each n-th is not heavy")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Of the cases of a test that is marked ``one_of(n)`` leave each n-th, and mark the others heavy."""
    cases: Counter[str] = Counter()
    for item in items:
        if (mark := item.get_closest_marker("one_of")) is not None:
            test = item.nodeid.partition("[")[0]
            if cases[test] % mark.args[0]:
                item.add_marker(pytest.mark.heavy)
            cases[test] += 1
