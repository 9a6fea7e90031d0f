"""Child processes take Python's modules from Python, not from the folder in which a user is."""

import ast
import os
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from nrp_core._support.forked import Forker
from nrp_core._support.probe import run_module
from nrp_core._support.worker_pool import WorkerPool

ROOT = Path(__file__).parents[2]
SHIPPED = ("nrp_core", "backends", "bibi", "plugins", "experiments", "docs/site")
IN_TEXT = re.compile(r"\{python\} -[mc]\b")
SPAWNING = {"ProcessPoolExecutor", "get_context", "set_start_method"}
"""Names of ``multiprocessing``, whose children look in the working directory first."""


def unsafe_starts(tree: ast.AST) -> Iterator[int]:
    """Yield the lines in which a Python is started that looks for modules in its working directory."""
    for node in ast.walk(tree):
        match node:
            case ast.List(elts=words) | ast.Tuple(elts=words):
                for before, word in pairwise(words):
                    program = ast.unparse(before)
                    is_python = "executable" in program or "python" in program
                    if is_python and isinstance(word, ast.Constant) and word.value in ("-m", "-c"):
                        yield node.lineno
            case ast.Constant(value=str(text)) if IN_TEXT.search(text):
                yield node.lineno
            case ast.Name(id=name) | ast.Attribute(attr=name) if name in SPAWNING:
                yield node.lineno


def test_no_shipped_module_starts_a_python_that_imports_from_the_working_directory() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for folder in SHIPPED
        for path in sorted((ROOT / folder).rglob("*.py"))
        if not {"tests", "node_modules", "peers"} & set(path.relative_to(ROOT).parts)
        for line in unsafe_starts(ast.parse(path.read_bytes()))
    ]
    assert found == []


@pytest.mark.parametrize(
    "start",
    [
        "run([sys.executable, '-m', 'x'])",
        "run((executable(), '-c', 'x'))",
        "command = ['python3', '-m', 'x']",
        "text = f'exec {python}' + ' -m x'.format() or 'exec {python} -m x'",
        "with ProcessPoolExecutor(1): pass",
        "multiprocessing.get_context('spawn')",
    ],
)
def test_an_unsafe_start_is_found(start: str) -> None:
    assert list(unsafe_starts(ast.parse(start))) == [1]


@pytest.mark.parametrize(
    "start",
    ["run([sys.executable, '-P', '-m', 'x'])", "run(['python', '-I', '-c', 'x'])", "['sh', '-c', 'x']"],
)
def test_a_safe_start_is_not_reported(start: str) -> None:
    assert list(unsafe_starts(ast.parse(start))) == []


PLANTED = ("base64", "select", "json", "socket", "pickle", "typing", "random", "hashlib", "nrp_core")


@pytest.fixture
def planted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with modules that have names of Python's, and leave a file if imported."""
    for name in PLANTED:
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'MARK')!r}, 'a').write({name!r})\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def asked(site: Path) -> str:
    """The name of a module that children import from their path."""
    text = (
        f"def load(): import {', '.join(PLANTED)}\ndef main():\n    load()\n    print('done')\n    return 0\n"
    )
    (site / "asked.py").write_text(f"{text}if __name__ == '__main__': main()\n")
    return "asked"


def test_modules_beside_a_user_do_not_replace_those_of_a_child(planted: Path, asked: str) -> None:
    assert run_module(asked, timeout_s=30.0).output == "done\n"
    forker = Forker()
    assert forker.run(asked, [], 30.0) is None  # the first time is for a new interpreter
    result = forker.run(asked, [], 30.0)
    forker.end()
    assert result is not None
    assert result.output == "done\n"
    with WorkerPool(1) as pool:
        (outcome,) = pool.perform(os.path.basename, ["a/b"])
    assert outcome.value == "b"
    assert not (planted / "MARK").exists()
