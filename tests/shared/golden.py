"""The messages that the tests of a folder meet stand in its ``messages.txt``, which is read as one text.

A test asserts types, codes, places, names and values, and hands sentences to the fixture ``golden``. An
entry of the file is the name of a test and its messages, a line each, under the cases that have them.
"""

from __future__ import annotations

import difflib
import re
import sys
import tempfile
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from operator import itemgetter
from pathlib import Path
from typing import TypeVar

import pytest

E = TypeVar("E", bound=BaseException)

FILE = "messages.txt"
_REPOSITORY = Path(__file__).resolve().parents[2]
_VARYING = (  # what differs between machines, runs and edits of the tests, and what stands for it
    (re.compile(re.escape(sys.executable)), "PYTHON"),
    (re.compile(rf"{re.escape(str(_REPOSITORY))}/(?!\.venv)"), ""),
    (re.compile(rf"{re.escape(tempfile.gettempdir())}/[\w-]+(/tmp\w{{8}})*(?=[/\s'\"])"), "TMP"),
    (re.compile(r"\bport \d+"), "port N"),
    (re.compile(r"Unable to synchronously open file.*"), "Unable to open file ..."),  # of HDF5
    (re.compile(r"[^\s'\"]*/site-packages/"), "PACKAGES/"),
    (re.compile(r"(test_\w+\.py(:|\", line ))\d+"), r"\1N"),
    (re.compile(r"(nrp-core )\d+\.\d+\.\d+"), r"\1VERSION"),
    (re.compile(r"valid: [^;]* and \d+ more"), "valid: ... and N more"),
    (re.compile(r"[\d.]+ [KMGT]iB are free"), "N GiB are free"),
    (re.compile(r"\b0x[0-9a-f]{6,}|(?<=@)[0-9a-f]{8,}"), "ADDRESS"),
    (re.compile(r" \[type=\w+, input_value=.*\n *For further information visit .*"), ""),  # of pydantic
    (re.compile(r" \[NRP\d+\]$"), ""),  # tests assert codes
    (re.compile(r"\b[0-9a-f]{32,}\b"), "DIGEST"),
    (re.compile(r"[^\S \n]|[\0-\x08\x0e-\x1f\ud800-\udfff]"), lambda found: ascii(found[0])[1:-1]),
)
_COLLECTED = pytest.StashKey[set[tuple[Path, tuple[str, str]]]]()
_UPDATED = pytest.StashKey[dict[Path, dict[tuple[str, str], str]]]()


class Golden:
    """The messages of a test, which are compared with its entry when it has passed."""

    def __init__(self, temporary: Path) -> None:
        folder = re.compile(rf"{re.escape(str(temporary))}(/[\w-]*)?")
        self._varying = ((folder, "TMP"), *_VARYING)
        self._messages: list[str] = []

    def __call__(self, *messages: object) -> None:
        """Add messages; one that repeats the message before it is the same line of the file."""
        for message in messages:
            text = str(message)
            for pattern, replacement in self._varying:
                text = pattern.sub(replacement, text)
            first, *others = filter(None, (line.rstrip() for line in text.split("\n")))
            text = "".join([f"    {first}\n", *(f"      {line}\n" for line in others)])
            if text not in self._messages[-1:]:
                self._messages.append(text)

    @contextmanager
    def raises(
        self, error: type[E] | tuple[type[E], ...], match: str = ""
    ) -> Iterator[pytest.ExceptionInfo[E]]:
        """As ``pytest.raises``, and the message is added; ``match`` is for names and values."""
        with pytest.raises(error, match=re.compile(match, re.DOTALL) if match else None) as caught:
            yield caught
        self(caught.value)

    @property
    def text(self) -> str:
        return "".join(self._messages)


@pytest.fixture
def golden(tmp_path_factory: pytest.TempPathFactory) -> Golden:
    return Golden(tmp_path_factory.getbasetemp())


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-messages", action="store_true", help=f"write {FILE} of the tests that run")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_UPDATED] = {}
    if config.getoption("update_messages") and config.getoption("numprocesses", None):
        raise pytest.UsageError("--update-messages needs -n 0, where one process sees all tests")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None]:
    """Compare, or keep for the update, the messages of a test that has passed."""
    yield
    golden = getattr(item, "funcargs", {}).get("golden")
    file, test = item.path.with_name(FILE), _name(item)
    if item.config.getoption("update_messages"):
        item.config.stash[_UPDATED].setdefault(file, {})[test] = golden.text if golden else ""
    if golden is None or item.config.getoption("update_messages"):
        return
    expected = read(file).get(test, "")
    if golden.text != expected:
        change = "".join(difflib.ndiff(expected.splitlines(True), golden.text.splitlines(True)))
        update = f"pytest -n 0 --update-messages '{item.nodeid}'"
        pytest.fail(f"{file}:\n{change}if this is right: {update}", pytrace=False)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Note all tests, before options select some."""
    config.stash[_COLLECTED] = {(item.path.parent, _name(item)) for item in items}


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write the entries of the tests that ran, and drop those of tests and cases that are gone."""
    for file, updated in session.config.stash[_UPDATED].items():
        tests = {test for folder, test in session.config.stash[_COLLECTED] if folder == file.parent}
        functions = {function for function, _ in tests}
        kept = {
            test: text
            for test, text in read(file).items()
            if test in tests or (test[0] not in functions and exists(file, test[0]))
        }
        write(file, kept | updated)


def exists(file: Path, test: str) -> bool:
    """Whether the function of an entry is in its module."""
    module, *_, function = test.split("::")
    source = file.with_name(module)
    return source.exists() and f"def {function}(" in source.read_text("utf-8")


def _name(item: pytest.Item) -> tuple[str, str]:
    """The name of a test in the file of its folder, and the case in brackets."""
    function, bracket, case = item.nodeid.partition("::")[2].partition("[")
    return f"{item.path.name}::{function}", bracket + case


def read(file: Path) -> dict[tuple[str, str], str]:
    """The lines of each test and case in a golden file."""
    entries: dict[tuple[str, str], str] = {}
    test, cases, lines = "", [""], ""
    for line in file.read_text("utf-8").split("\n") if file.exists() else ():
        if line.startswith("    "):
            lines += f"{line}\n"
            continue
        if lines:
            entries |= dict.fromkeys(((test, case) for case in cases), lines)
            cases, lines = [], ""
        if line.startswith("  "):
            cases.append(line.strip())
        elif line:
            test, cases = line, [""]
    return entries


def write(file: Path, entries: Mapping[tuple[str, str], str]) -> None:
    """Write a golden file, sorted by test and case; cases with the same messages follow each other."""
    blocks: dict[str, dict[str, list[str]]] = {}
    for (test, case), lines in sorted(filter(itemgetter(1), entries.items())):
        blocks.setdefault(test, {}).setdefault(lines, []).append(f"  {case}\n" if case else "")
    tests = (
        f"{test}\n" + "".join("".join(cases) + lines for lines, cases in found.items())
        for test, found in blocks.items()
    )
    if blocks or file.exists():
        file.write_text("\n".join(tests), "utf-8")
