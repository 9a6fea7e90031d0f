"""Axes of a sweep's figures name their units, and numbers in different units are not put on one axis."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_lab.sweep.figures import draw
from nrp_lab.sweep.table import SweepTable


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
