"""Decisions are short, are listed, and name what exists."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "decisions"
REFERENCE = ROOT / "docs" / "reference" / "python.md"
DECISIONS = sorted(FOLDER.glob("0*.md"))
MOST_WORDS = 300
CODE = re.compile(r"`([^`]+)`")


def words_in(text: str) -> int:
    """Return the number of words, without code and the targets of links."""
    prose = re.sub(r"\]\([^)]*\)|`[^`]*`", "", text)
    return len(re.findall(r"[A-Za-z][A-Za-z'-]+", prose))


def named_and_missing(text: str) -> list[str]:
    """Return the modules and files of the project that a page names and that do not exist."""
    groups = re.findall(r"`(nrp_core\.\w+)`", REFERENCE.read_text("utf-8").partition("\n## Plugins\n")[2])
    missing: list[str] = []
    for name in CODE.findall(text):
        if re.fullmatch(r"nrp_[\w.]+", name) and "." in name:
            missing += [] if name in groups or exists(name) else [name]
        elif re.fullmatch(r"(nrp_core|backends|plugins|benchmarks|bibi)/[\w./-]+", name):
            missing += [] if (ROOT / name).exists() else [name]
    return missing


def exists(name: str) -> bool:
    module, _, last = name.rpartition(".")
    file = name.replace(".", "/")
    if any(ROOT.glob(f"plugins/*/src/{file}.py")):  # most plugins have an environment of their own
        return True
    try:
        importlib.import_module(name)
    except ImportError:
        return bool(module) and hasattr(importlib.import_module(module), last)
    return True


@pytest.mark.parametrize("page", DECISIONS, ids=lambda page: page.stem)
def test_a_decision_is_short_and_names_what_exists(page: Path) -> None:
    text = page.read_text("utf-8")
    assert words_in(text) <= MOST_WORDS
    assert named_and_missing(text) == []


def test_the_list_of_decisions_is_complete() -> None:
    listed = re.findall(
        r"^\d+\. \[[^\]]+\]\((\S+)\)$", (FOLDER / "README.md").read_text("utf-8"), re.MULTILINE
    )
    assert listed == [page.name for page in DECISIONS]


def test_a_long_page_and_a_missing_module_are_found() -> None:
    assert words_in("some words, `code here` and [a link](to/a-page.md)") == 4
    assert named_and_missing("`nrp_core.scene.rigid`, `nrp_core.absent`, `benchmarks/absent.py`") == [
        "nrp_core.absent", "benchmarks/absent.py",
    ]  # fmt: skip
