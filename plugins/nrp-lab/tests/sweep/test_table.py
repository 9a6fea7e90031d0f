"""The tables of a sweep hold every kind of value."""

import csv
from pathlib import Path

import pyarrow.parquet as pq
from nrp_lab.sweep import sweep
from nrp_lab.sweep.table import Row, write_tables


def test_a_parameter_that_is_given_with_and_without_its_unit_is_a_column_of_texts(tmp_path: Path) -> None:
    rows: list[Row] = [
        {"run": 0, "brain.parameters.gain": 0.5, "seed": 7, "passed": True, "complete": True},
        {"run": 1, "brain.parameters.gain": "1 mV", "seed": 8, "passed": None, "complete": True},
    ]
    _, file = write_tables(tmp_path, rows, {})
    table = pq.read_table(file).to_pydict()
    assert table["brain.parameters.gain"] == ["0.5", "1 mV"]
    assert table["seed"] == [7, 8]
    assert table["passed"] == [True, None]


def test_a_table_has_the_units_of_metrics_and_observables(tmp_path: Path) -> None:
    measured = {
        "experiment": "hovering_quadrotor",
        "vary": {"seed": [1]},
        "until": "20 ms",
        "settings": {"observables": "{lift: {height: quadrotor}, lean: {tilt: quadrotor}}"},
        "measure": ["observables", "distance", "cv"],
    }
    frame = sweep(measured, workers=1, out=tmp_path / "out")
    units = frame.attrs["units"]
    assert units["observables.lift.max"] == units["distance.quadrotor"] == "m"
    assert units["observables.lean.last"] == "rad"
    assert not any(name.startswith("cv.") for name in units)
    assert units.keys() <= set(frame)
    with (tmp_path / "out" / "units.csv").open(newline="") as file:
        assert {row["column"]: row["unit"] for row in csv.DictReader(file)} == units
