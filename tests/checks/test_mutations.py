"""Experiments that work, each broken in one way: nearly all of it is found before the run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from nrp_core.checks.validate import validate_file
from nrp_core.experiment.reading.find import shipped
from nrp_core.findings import Finding, Level

MUTATIONS: list[dict[str, Any]] = YAML(typ="safe").load(Path(__file__).with_name("mutations.yaml"))
CORPUS = Path(__file__).parents[2] / "plugins" / "nrp-legacy" / "tests" / "corpus"


@pytest.mark.one_of(8)
@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation["kind"].replace(" ", "-"))
def test_mistakes_are_found_before_the_run(
    broken: Callable[..., list[Finding]], husky: Path, mutation: dict[str, Any]
) -> None:
    experiment = mutation.get("experiment", "experiment.yaml")
    found = broken(mutation["file"], *mutation["changes"], experiment=experiment)
    code = mutation.get("code")
    if code is None:
        assert not found, "it is found by now: give it its code"
        return
    assert code in {finding.code.name for finding in found}, "\n".join(map(str, found))
    finding = next(finding for finding in found if finding.code.name == code)
    assert finding.path is not None
    assert finding.path.is_relative_to(husky)
    assert finding.line == mutation.get("line", finding.line) is not None


def test_nineteen_of_twenty_kinds_of_mistakes_are_found() -> None:
    kinds = [mutation["kind"] for mutation in MUTATIONS]
    assert len(set(kinds)) == len(kinds) >= 60
    assert sum("code" in mutation for mutation in MUTATIONS) >= 0.95 * len(MUTATIONS)


@pytest.mark.one_of(6)
@pytest.mark.parametrize("name", shipped())
def test_nothing_is_wrong_with_what_ships(name: str) -> None:
    assert [finding for finding in validate_file(name) if finding.level is not Level.NOTE] == []


@pytest.mark.one_of(8)
@pytest.mark.parametrize("name", ["bare", "husky_2015", "husky_2017", "husky_2019"])
def test_experiments_of_the_platform_have_no_errors(name: str) -> None:
    found = validate_file(CORPUS / name, [f"models=[{CORPUS / 'models'}]"])
    assert [str(finding) for finding in found if finding.level is Level.ERROR] == []
