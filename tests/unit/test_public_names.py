"""The doors of the core: which names they offer, and that everybody outside uses these alone."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from golden import Golden
from public_names import DOORS, public_modules

import nrp_core.dsl

ROOT = Path(__file__).parents[2]
MODULE = r"(nrp_(?:conformance|core|formats|lab)[\w.]*)"
IMPORT = re.compile(rf"^[ >]*(?:from {MODULE} import (\([^)]*\)|[^\n#]*)|import {MODULE})", re.MULTILINE)

OWN_FILE = re.compile(r"^```python\n# (?:nrp_core|backends)/.*?^```$", re.MULTILINE | re.DOTALL)
"""A block of a page that becomes a file of the project itself, which does not use the doors."""


def is_public(module: str) -> bool:
    known = public_modules()
    return module in known or f"{module.rpartition('.')[0]}.*" in known


NRP_CORE_4 = "run-an-nrp-core-4-experiment.md"


def outside() -> list[Path]:
    """What is written as users and authors would: pages, templates, plugins and experiments.

    The page about NRP-core 4 imports that program's ``nrp_core``.
    """
    patterns = (
        "README.md", "CONTRIBUTING.md", "docs/*/*.md", "experiments/**/*.py", "experiments/*.md",
        "nrp_core/cli/templates/**/*.j2", "plugins/*/src/**/*.py", "plugins/*/README.md",
        "plugins/nrp-*-minimal/tests/*.py", "tests/third_party/acme_lab/**/*.py",
    )  # fmt: skip
    found = (path for pattern in patterns for path in ROOT.glob(pattern))
    return sorted(path for path in found if not {"decisions", NRP_CORE_4} & set(path.parts))


def imported(text: str) -> Iterator[tuple[str, str]]:
    """Yield module and name of every import of the core in a file or page; the name is empty for a module."""
    for module, names, whole in IMPORT.findall(text):
        if whole:
            yield whole, ""
        for name in re.sub(r"[()\s]+", " ", names).split(","):
            if name.strip():
                yield module, name.split()[0]


def in_type_checking(package: str) -> dict[str, str]:
    """Return what a door imports for type checkers: the module of each name."""
    source = Path(str(importlib.import_module(package).__file__)).read_text()
    (block,) = (node for node in ast.parse(source).body if isinstance(node, ast.If))
    found = (node for node in block.body if isinstance(node, ast.ImportFrom))
    return {alias.name: str(node.module) for node in found for alias in node.names if alias.asname}


@pytest.mark.parametrize("door", DOORS)
def test_every_name_of_a_door_imports_and_is_the_one_that_type_checkers_see(door: str) -> None:
    package = importlib.import_module(door)
    typed = in_type_checking(door)
    assert sorted(typed) == package.__all__
    for name, module in typed.items():
        home = importlib.import_module(module)
        expected = getattr(home, name, None) or importlib.import_module(f"{module}.{name}")
        assert getattr(package, name) is expected
        assert name in dir(package)


@pytest.mark.parametrize("door", DOORS)
def test_every_name_of_a_door_is_documented(door: str) -> None:
    package = importlib.import_module(door)
    for name in package.__all__:
        value = getattr(package, name)
        is_alias = hasattr(value, "__origin__")  # of a type, which has no docstring
        if isinstance(value, type) or (callable(value) and not is_alias) or hasattr(value, "__path__"):
            assert (value.__doc__ or "").strip(), name


@pytest.mark.parametrize("door", DOORS)
def test_a_misspelt_name_is_an_attribute_error_that_names_it(door: str, golden: Golden) -> None:
    with golden.raises(AttributeError, match=f"'{door}'.*'Wrold'"):
        importlib.import_module(door).Wrold  # noqa: B018  the access is the test


def test_the_doors_import_nothing_until_a_name_is_used() -> None:
    script = (
        "import sys; bare = set(sys.modules); import nrp_core, nrp_core.brain, nrp_core.world; "
        "print(*sorted(set(sys.modules) - bare))"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    found = set(run.stdout.split())
    assert {name for name in found if name.startswith("nrp_core")} == {
        "nrp_core", "nrp_core._support", "nrp_core._support.collector", "nrp_core._support.lazy",
        "nrp_core.brain", "nrp_core.world",
    }  # fmt: skip
    assert len(found) <= 13, found


def test_every_public_module_of_the_reference_imports_and_its_names_exist() -> None:
    for module in public_modules():
        package = importlib.import_module(module.removesuffix(".*"))
        for name in getattr(package, "__all__", ()):
            assert getattr(package, name) is not None


def test_the_reference_lists_exactly_the_public_names() -> None:
    page = (ROOT / "docs" / "reference" / "python.md").read_text()
    for door in DOORS:
        section = page.partition(f"\n## `{door}`\n")[2].partition("\n## ")[0]
        rows = re.findall(r"^\| (`[^|]+`) \|", section, re.MULTILINE)
        assert sorted(re.findall(r"`(\w+)`", " ".join(rows))) == importlib.import_module(door).__all__


def test_the_names_that_extend_the_language_exist_and_are_in_the_reference() -> None:
    page = (ROOT / "docs" / "reference" / "python.md").read_text()
    (row,) = re.findall(r"^\| `nrp_core\.dsl` \|.*also import (.*) \|$", page, re.MULTILINE)
    assert re.findall(r"`(\w+)`", row) == nrp_core.dsl.EXTENSION_NAMES
    assert all(hasattr(nrp_core.dsl, name) for name in nrp_core.dsl.EXTENSION_NAMES)
    assert not set(nrp_core.dsl.__all__) & set(nrp_core.dsl.EXTENSION_NAMES)


@pytest.mark.parametrize("path", outside(), ids=lambda path: str(path.relative_to(ROOT)))
def test_code_outside_the_core_uses_public_names_only(path: Path) -> None:
    for module, name in imported(OWN_FILE.sub("", path.read_text())):
        if module.partition(".")[0] in path.parts:  # of the same distribution
            continue
        assert is_public(module) or is_public(f"{module}.{name}"), f"{module}.{name}"
        package = importlib.import_module(module)
        names = getattr(package, "__all__", None)
        if names is not None and name:
            assert name in [*names, *getattr(package, "EXTENSION_NAMES", ())] or is_public(
                f"{module}.{name}"
            ), f"{module}.{name}"


def test_the_core_itself_does_not_go_through_its_doors() -> None:
    for path in (ROOT / "nrp_core").rglob("*.py"):
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for origin, name in imported(path.read_text()):
            if origin in DOORS and ">>>" not in path.read_text():
                submodule = f"{origin}.{name}".replace(".", "/")
                known = (ROOT / f"{submodule}.py").exists() or (ROOT / submodule).is_dir()
                assert known or not name, f"{module} imports {name} from {origin}"
