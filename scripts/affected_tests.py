#!/usr/bin/env python3
"""Print the tests that a change can affect, the nearest by imports first.

The change is what differs from a commit (by default from ``main`` on another branch, else from the last
commit), with what is not committed. A test is near a module if it imports the module, or imports what imports
it; at the same distance, the tests whose paths share words with the change come first. Tests are chosen until
they need ``--seconds``, as ``scripts/test`` measured them last. A test that names a changed file of another
kind counts as one that imports it.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SECONDS = ROOT / ".venv" / "test_seconds.json"
FARTHEST = 3  # imports; from there on, nearly every file imports every other
BLOCKS = "tests/docs/test_docs.py::test_every_block_of_a_page_runs"
DOOR = "lazily(__name__)"  # of a package whose names are imported when they are first used
GUARD = "\nif TYPE_CHECKING:\n"
IMPORT = re.compile(r"^ *(?:from ([\w.]+) import (\([^)]*\)|[^\n#]*)|import ([\w.]+))", re.MULTILINE)
NAME = re.compile(r"\w+(?: as \w+)?")
WORD = re.compile(r"[a-z]{4,}")
COMMON = frozenset({"core", "tests", "test", "unit", "plugins", "backends", "world", "brain", "messages"})


def git(*arguments: str) -> list[str]:
    """Return the lines that git prints."""
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def changed_files(base: str | None) -> set[str]:
    """Return the files that differ from a commit."""
    if base is None:
        branch = "HEAD" if git("branch", "--show-current") == ["main"] else "main"
        base = git("merge-base", branch, "HEAD")[0]
    return {*git("diff", "--name-only", base), *git("ls-files", "--others", "--exclude-standard")}


def module_name(path: str) -> str:
    """Return the dotted name of a module; its packages are the folders with an ``__init__.py``."""
    parts = [Path(path).stem]
    for folder in Path(path).parents:
        if not (ROOT / folder / "__init__.py").exists():
            break
        parts.insert(0, folder.name)
    return ".".join(parts).removesuffix(".__init__")


def names_of_door(text: str) -> dict[str, str]:
    """Return the module of each name that a package imports for type checkers only."""
    imports = IMPORT.findall(text.partition(GUARD)[2])
    return {name.split(" ")[0]: module for module, names, _ in imports for name in NAME.findall(names)}


class Imports:
    """Which files import which, also through packages whose names are imported on first use.

    Args:
        paths: the Python files of the repository.
    """

    def __init__(self, paths: list[str]) -> None:
        self._path_of = {module_name(path): path for path in paths}
        texts = {path: (ROOT / path).read_text("utf-8") for path in paths}
        doors = {name: path for name, path in self._path_of.items() if DOOR in texts[path]}
        self._homes = {name: names_of_door(texts[path]) for name, path in doors.items()}
        self._importers: dict[str, set[str]] = defaultdict(set)
        for path, text in texts.items():
            for imported in self._imported(text.partition(GUARD)[0] if path in doors.values() else text):
                self._importers[imported].add(path)

    def _imported(self, text: str) -> Iterator[str]:
        """Yield the files that a file imports."""
        for module, names, whole in IMPORT.findall(text):
            homes = [self._home(module, name.split(" ")[0]) for name in NAME.findall(names)]
            yield from (self._path_of[name] for name in homes or [whole] if name in self._path_of)

    def _home(self, module: str, name: str) -> str:
        inner = f"{module}.{name}"
        return inner if inner in self._path_of else self._homes.get(module, {}).get(name, module)

    def distances(self, changed: Iterable[str]) -> dict[str, int]:
        """Return the number of imports between each file and the nearest changed one."""
        known = dict.fromkeys(changed, 0)
        nearest = list(known)
        for distance in range(1, FARTHEST + 1):
            nearest = [path for each in nearest for path in self._importers[each] if path not in known]
            known.update(dict.fromkeys(nearest, distance))
        return known


def words(path: str) -> set[str]:
    """Return the words of a path that say what it is about."""
    return {word.rstrip("s") for word in WORD.findall(path.removesuffix(".py"))} - COMMON


def tests_that_name(path: Path, texts: dict[str, str]) -> Iterator[str]:
    """Yield the tests whose text names a file, or its folder if the file is a part of an experiment."""
    names = [path.name, path.parent.name] if "nrp_experiments" in path.parts else [path.name]
    for test, text in texts.items():
        if path.parent == Path(test).parent or any(f'{name}"' in text for name in names):
            yield test


def affected_tests(changed: set[str], most_s: float) -> list[str]:
    """Return the test files that a change can affect, and the changed pages, whose blocks are tests."""
    files = [path for path in git("ls-files", "-co", "--exclude-standard", "*.py") if (ROOT / path).exists()]
    near = Imports([path for path in files if not path.startswith("stubs")]).distances(changed & set(files))
    suite = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["pytest"]["ini_options"]["testpaths"]
    tests = [path for path in files if Path(path).name.startswith("test_") and path.startswith(tuple(suite))]
    tests = [path for path in tests if "/browser/" not in path]  # scripts/test-browser runs them
    texts = {path: (ROOT / path).read_text("utf-8") for path in tests}
    for path in changed - set(files):
        if (ROOT / path).exists() and not path.endswith(".md"):
            near |= dict.fromkeys(
                (test for test in tests_that_name(Path(path), texts) if test not in near), 1
            )
    measured = json.loads(SECONDS.read_text()) if SECONDS.exists() else {}
    seconds = {
        test: measured.get(test, 0.5 + 0.1 * text.count("\ndef test_")) for test, text in texts.items()
    }
    subjects = {word for path in changed for word in words(path)}
    chosen, total_s = [], 0.0
    for test in sorted(
        near.keys() & texts.keys(),
        key=lambda path: (near[path], -len(words(path) & subjects), seconds[path], path),
    ):
        if near[test] == 0 or total_s + seconds[test] <= most_s:
            total_s += seconds[test]
            chosen.append(test)
    pages = [path for path in sorted(changed) if path.endswith(".md") and (ROOT / path).exists()]
    return [*chosen, *(f"{BLOCKS}[{page}]" for page in pages if "\n```" in (ROOT / page).read_text("utf-8"))]


def main() -> None:
    """Print the tests."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("base", nargs="?", help="the commit that the change begins with")
    parser.add_argument("--seconds", type=float, default=60.0, help="how long the tests take at most")
    options = parser.parse_args()
    print("\n".join(affected_tests(changed_files(options.base), options.seconds)))


if __name__ == "__main__":
    main()
