"""Figures and summaries of a sweep name their units, and an axis has numbers of one unit."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_lab.sweep.figures import draw
from nrp_lab.sweep.report import report, report_data
from nrp_lab.sweep.table import SweepTable
from rich.console import Console


@pytest.mark.parametrize(
    ("values", "label", "ticks"),
    [
        (("1 ms", "2 ms"), "world.timestep (ms)", ()),
        ((1, 2), "world.timestep", ()),
        (("500 ms", "1 s"), "world.timestep", ("500 ms", "1 s")),
    ],
)
@pytest.mark.parametrize("kind", ["curve", "heat"])
def test_the_axes_of_a_curve_have_units(
    tmp_path: Path, values: tuple[object, ...], label: str, ticks: tuple[str, ...], kind: str
) -> None:
    keys = ("world.timestep", "seed") if kind == "heat" else ("world.timestep",)
    rows = tuple(
        {"world.timestep": value, "seed": 1, "distance.husky": 0.5, "run": n}
        for n, value in enumerate(values)
    )
    path = tmp_path / "figure.svg"
    draw(SweepTable("drive", keys, ("distance.husky",), rows), path, kind=kind)
    text = path.read_text()
    assert "distance.husky (m)" in text
    assert all(f"{tick}<" in text or f"{tick} -->" in text for tick in ticks)
    if kind == "curve":
        last = label.rpartition(".")[2]
        assert f"{last}<" in text or f"{last} -->" in text
        assert ("(ms)" in text) == ("(ms)" in label)


def test_the_summary_has_the_unit_of_each_measure(tmp_path: Path) -> None:
    rows = (
        {"seed": 1, "run": 0, "distance.husky": 0.5, "cv.circuit": 0.1, "error": None, "complete": True}
        | {"passed": None, "trajectory_digest": "a"},
    )
    table = SweepTable("drive", (), ("distance.husky", "cv.circuit"), rows)
    assert report_data(table, tmp_path, None)["units"] == {"distance.husky": "m", "cv.circuit": ""}
    console = Console(width=100, record=True)
    report(table, console)
    assert "(m)" in console.export_text().split()
