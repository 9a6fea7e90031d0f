"""Every block of code in the documentation runs.

Blocks of one page run in order, in one fresh folder: ``sh`` as a script, ``python`` as a program; a
block whose first line is a comment with a file name is written to that file instead. Blocks of language
``text`` show output, those of ``math`` equations. A block after ``<!-- not run: reason -->`` is skipped.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from nrp_core.cli.commands import COMMANDS

ROOT = Path(__file__).parents[2]
DOCS = [page for page in (ROOT / "docs").rglob("*.md") if "site" not in page.parts[len(ROOT.parts) :]]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *DOCS])
READMES = sorted(
    [
        *(ROOT / name / "README.md" for name in ("changes", "experiments")),
        *(ROOT / "plugins").glob("*/README.md"),
    ]
)

BLOCK = re.compile(r"(<!-- not run: .+? -->\n)?^```(\w+)[^\n]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE_NAME = re.compile(r"(?:#|<!--) ([\w./-]+\.\w+)(?: -->)?\n")
SHOWN = {"text", "math"}
RUNS_AS = {"sh": ["bash", "-e"], "python": ["python"]}
MANY_RUNS = frozenset(
    f"docs/{name}.md"
    for name in (
        "howto/contribute-a-synapse-law", "howto/compare-simulators", "howto/evolve-settings",
        "howto/judge-a-run", "howto/use-pynn", "howto/use-your-robot", "howto/write-a-cell-in-equations",
        "tutorial/first-experiment", "tutorial/biology-and-equations",
        "howto/intervene-in-a-brain", "howto/learn-in-the-loop", "howto/map-to-spinnaker",
        "howto/pack-a-paper", "howto/prove-a-backend", "howto/run-spynnaker-scripts",
        "howto/record-and-replay", "howto/run-a-fly", "howto/set-parameters", "howto/steer-a-run",
        "howto/sweep-settings", "howto/write-a-learning-rule", "tutorial/one-run-to-a-thousand",
        "tutorial/own-experiment",
    )
)  # fmt: skip
"""Pages that take minutes together; other tests run the same commands."""
COPIES_SOURCES = "docs/howto/contribute-a-synapse-law.md"
"""A page that changes a copy of the sources; warm programs have those of this clone in memory."""


@dataclass(frozen=True)
class Block:
    """One block of code."""

    language: str
    text: str
    line: int


def blocks(page: Path) -> Iterator[Block]:
    text = page.read_text()
    for match in BLOCK.finditer(text):
        if not match[1] and match[2] not in SHOWN:
            yield Block(match[2], match[3], text[: match.start()].count("\n") + 1)


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=pytest.mark.heavy if name_of(page) in MANY_RUNS else ())
        for page in PAGES
        if any(blocks(page))
    ],
    ids=name_of,
)
def test_every_block_of_a_page_runs(page: Path, warm: Path, tmp_path: Path) -> None:
    programs = Path(sys.executable).parent if name_of(page) == COPIES_SOURCES else warm
    run_blocks(page, tmp_path, programs)


def run_blocks(page: Path, tmp_path: Path, warm: Path) -> None:
    """Run the blocks of a page in order, in one folder, with the programs of another."""
    path = os.pathsep.join(map(str, (warm, Path(sys.executable).parent, os.environ["PATH"])))
    for block in blocks(page):
        named = FILE_NAME.match(block.text)
        if named:
            file = tmp_path / named[1]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.text)
            continue
        assert block.language in RUNS_AS, f"{page}:{block.line}: nothing runs a block of '{block.language}'"
        done = subprocess.run(
            RUNS_AS[block.language], input=block.text, cwd=tmp_path, env={**os.environ, "PATH": path},
            capture_output=True, text=True, timeout=300, check=False,
        )  # fmt: skip
        assert done.returncode == 0, f"{page}:{block.line}\n{done.stdout}\n{done.stderr}"


@pytest.mark.slow
@pytest.mark.parametrize(
    "block",
    [
        "```python\nraise SystemExit(3)\n```\n",
        "```python\nimport os\nos.kill(os.getpid(), 9)\n```\n",
        "```sh\nnrp explain NRP000\ntrue\n```\n",
        "```python\nimport nrp_core\nnrp_core.of_another_block\n```\n",
    ],
    ids=["exit code", "signal", "command", "state of another"],
)
def test_a_block_that_fails_is_named(block: str, warm: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"```python\nimport nrp_core\nnrp_core.of_another_block = 1\n```\n{block}")
    with pytest.raises(AssertionError, match=r"page\.md:5"):
        run_blocks(page, tmp_path, warm)


@pytest.mark.parametrize("page", [*PAGES, *READMES], ids=name_of)
def test_every_link_of_a_page_leads_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", BLOCK.sub("", page.read_text())):
        if "://" not in link:
            target, _, heading = link.partition("#")
            file = page.parent / target if target else page
            assert file.exists(), f"{page.name} links to {target}"
            assert not heading or heading in headings(file), f"{page.name} links to {link}"


def headings(page: Path) -> set[str]:
    """Return the headings of a page as links name them."""
    titles = re.findall(r"^#+ (.+)$", BLOCK.sub("", page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title).strip().lower().replace(" ", "-") for title in titles}


def test_every_command_stands_in_the_reference() -> None:
    names = set(COMMANDS)
    names |= {entry.name for entry in entry_points(group="nrp_core.commands")}
    reference = (ROOT / "docs" / "reference" / "command-line.md").read_text()
    assert names <= set(re.findall(r"^\| `nrp ([\w-]+)", reference, re.MULTILINE))


@pytest.mark.parametrize(
    "page", [p for p in PAGES if p.parents[1] == ROOT / "docs" and p.name != "README.md"]
)
def test_every_page_can_be_found_from_the_index(page: Path) -> None:
    index = page.parent if page.parent.name == "decisions" else page.parents[1]
    assert f"({page.relative_to(index)})" in (index / "README.md").read_text()
