"""The messages of the tests, in one file a folder."""

from pathlib import Path

import pytest
from golden import FILE, exists, read

pytest_plugins = ["pytester"]
REPOSITORY = Path(__file__).resolve().parents[2]
TESTS = """
import pytest

def test_else():
    pass

@pytest.mark.parametrize("case", ["a", "b", "c"])
def test_refusal(golden, tmp_path, case):
    with golden.raises(ValueError, match="7"):
        raise ValueError(f"{tmp_path}/x: the length is 7.\\n\\n  more" + " than 5" * (case == "b"))
"""
ENTRIES = """test_it.py::test_refusal
  [a]
  [c]
    TMP/x: the length is 7.
        more
  [b]
    TMP/x: the length is 7.
        more than 5
"""


@pytest.fixture
def it(pytester: pytest.Pytester) -> pytest.Pytester:
    pytester.makepyfile(test_it=TESTS)
    pytester.path.joinpath(FILE).write_text(ENTRIES)
    return pytester


def test_the_update_writes_what_passes(it: pytest.Pytester) -> None:
    other = "test_it.py::test_else\n    z\n\ntest_it.py::test_gone\n    x\n\n"
    other += "test_it.py::test_refusal\n  [gone]\n    y\n"
    it.path.joinpath(FILE).write_text(other)
    for _ in range(2):
        it.inline_run("-p", "golden", "--update-messages").assertoutcome(passed=4)
        assert it.path.joinpath(FILE).read_text() == ENTRIES
    it.inline_run("-p", "golden").assertoutcome(passed=4)


def test_a_message_that_changed_or_has_no_entry_fails(it: pytest.Pytester) -> None:
    it.path.joinpath(FILE).write_text(ENTRIES.replace("more than 5", "more"))
    it.inline_run("-p", "golden").assertoutcome(passed=3, failed=1)
    it.path.joinpath(FILE).write_text(ENTRIES.replace("[c]", "[d]"))
    it.inline_run("-p", "golden").assertoutcome(passed=3, failed=1)
    it.path.joinpath(FILE).unlink()
    it.inline_run("-p", "golden").assertoutcome(passed=1, failed=3)


def test_every_entry_has_its_test() -> None:
    files = [*REPOSITORY.glob(f"tests/**/{FILE}"), *REPOSITORY.glob(f"plugins/*/tests/**/{FILE}")]
    assert [(file, test) for file in files for test, _ in read(file) if not exists(file, test)] == []
