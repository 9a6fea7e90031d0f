"""The reference of cells and synapses says what the tables and the backends say."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import pytest

from nrp_core.network.cells import CELLS
from nrp_core.network.parameters import Parameter
from nrp_core.network.pynn.equation_cells import cells_in_equations
from nrp_core.network.synapses import LAWS

GENERATOR = Path(__file__).parents[2] / "docs" / "generate_models.py"


@pytest.fixture
def generator(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.syspath_prepend(str(GENERATOR.parent))  # restores the path that the generator extends
    return runpy.run_path(str(GENERATOR))


def test_the_reference_of_models_is_that_of_the_tables(generator: dict[str, Any]) -> None:
    text = generator["TARGET"].read_text("utf-8")
    assert text == generator["page"](), "run docs/generate_models.py"


def test_every_cell_and_law_has_a_section_with_its_parameters(generator: dict[str, Any]) -> None:
    sections = generator["TARGET"].read_text("utf-8").split("\n## ")
    tables = {name: cell.parameters for name, cell in CELLS.items()}
    tables |= {law.pynn: law.parameters for law in LAWS.values()}
    tables |= {name: cell.default_parameters for name, cell in cells_in_equations().items()}
    for name, parameters in tables.items():
        (section,) = (each for each in sections if each.startswith(f"`{name}`"))
        assert [each for each in parameters if f"| `{each}` |" not in section] == []


def test_a_parameter_that_changes_makes_the_page_out_of_date(
    generator: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    parameters = LAWS["tsodyks_markram"].parameters
    monkeypatch.setitem(parameters, "U", Parameter(0.25))  # type: ignore[arg-type]
    assert generator["TARGET"].read_text("utf-8") != generator["page"]()
