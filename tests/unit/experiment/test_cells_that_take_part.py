"""Cells that are left out of a network, and speeds and angles that lose their meaning, are found."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code

SHIPPED = Path(str(files("nrp_experiments"))) / "slalom_pioneer"
Check = Callable[..., list[str]]


@pytest.fixture
def check(tmp_path: Path) -> Check:
    """Return the findings of some codes about the slalom with edits of its files: old and new text."""

    def checked(code: Code, file: str, *edits: tuple[str, str]) -> list[str]:
        for one in (one for one in SHIPPED.iterdir() if one.is_file()):
            (tmp_path / one.name).write_bytes(one.read_bytes())
        experiment = tmp_path / "experiment.yaml"
        experiment.write_text(experiment.read_text().replace("../bodies", f"{SHIPPED.parent}/bodies"))
        text = (tmp_path / file).read_text()
        for old, new in edits:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / file).write_text(text)
        return [one.message for one in validate_file(tmp_path) if one.code is code]

    return checked


def test_cells_that_nothing_drives_are_found_although_others_are_driven_and_read(check: Check) -> None:
    wheels = [(f"nrp.brain.feelers[{part}]", f"nrp.brain.wheels[{part}]") for part in (":CELLS", "CELLS:")]
    (found,) = check(Code.NRP377, "steer.py", *wheels)
    assert "no cell of the population 'feelers' can fire, and its synapses transmit none" in found


def test_a_brain_that_no_function_uses_is_not_reported(check: Check) -> None:
    """As in an environment whose agent drives the robot itself."""
    assert (
        check(Code.NRP377, "experiment.yaml", ("transfer_functions: [steer.py]", "transfer_functions: []"))
        == []
    )
