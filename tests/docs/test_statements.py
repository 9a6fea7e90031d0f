"""What the documentation states about the code agrees with the code."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from nrp_core.findings import Code
from tests.docs.test_docs import PAGES, ROOT, name_of

ARCHITECTURE = ROOT / "docs" / "explanation" / "architecture.md"
QUOTED = re.compile(r"^ +(why|fix): (.+)$", re.MULTILINE)
EXPLAINED = {part for code in Code for part in (code.value.why, code.value.suggestion)}


def unknown_quotes(text: str) -> list[str]:
    """Return the quoted reasons and remedies that no finding has."""
    return [quoted for _, quoted in QUOTED.findall(text) if quoted not in EXPLAINED]


def layers_of(text: str) -> list[list[str]]:
    """Return the layers of the core that the dependency rule states."""
    found = re.search(r"Inside the core: `([^`]+)`", text)
    assert found
    return [sorted(re.split(r"\s*\|\s*", layer.strip())) for layer in found[1].split(">")]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_reasons_and_remedies_are_quoted_as_findings_have_them(page: Path) -> None:
    assert unknown_quotes(page.read_text()) == []


def test_the_dependency_rule_is_the_contract_that_is_checked() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (contract,) = [one for one in contracts if one["name"] == "Layers of the core"]
    stated = layers_of(ARCHITECTURE.read_text())
    assert stated == [sorted(layer.split(" | ")) for layer in contract["layers"]]


def test_an_outdated_quote_and_a_missing_layer_are_found() -> None:
    assert unknown_quotes("    why: Without it the loop has no simulator.\n")
    assert layers_of("Inside the core: `cli > brain |\n   world`.") == [["cli"], ["brain", "world"]]


GROUP = re.compile(r'Registry(?:\[.*\])?\(\s*"(nrp_core\.\w+)"')
"""The entry-point group of a registry."""


def test_the_reference_lists_every_group_of_plugins() -> None:
    sources = [path for pattern in ("nrp_core", "plugins/*/src") for path in ROOT.glob(f"{pattern}/**/*.py")]
    groups = {group for path in sources for group in GROUP.findall(path.read_text())}
    assert len(groups) > 20
    table = (ROOT / "docs/reference/python.md").read_text().partition("| entry-point group |")[2]
    assert groups - set(re.findall(r"`(nrp_core\.\w+)`", table)) == set()


def test_the_places_that_contributors_are_sent_to_exist() -> None:
    table = (
        (ROOT / "CONTRIBUTING.md").read_text().partition("## Where things are")[2].partition("\n\nRead")[0]
    )
    named = re.findall(r"`([\w./-]+/[\w./-]*)`", table)
    assert len(named) > 40
    tops = {path.name for path in ROOT.iterdir()}
    assert [name for name in named if name.split("/")[0] in tops and not (ROOT / name).exists()] == []
