"""The tables of a sweep hold every kind of value."""

from pathlib import Path

import pyarrow.parquet as pq
from nrp_lab.sweep.table import Row, write_tables


def test_a_parameter_that_is_given_with_and_without_its_unit_is_a_column_of_texts(tmp_path: Path) -> None:
    rows: list[Row] = [
        {"run": 0, "brain.parameters.gain": 0.5, "seed": 7, "passed": True, "complete": True},
        {"run": 1, "brain.parameters.gain": "1 mV", "seed": 8, "passed": None, "complete": True},
    ]
    _, file = write_tables(tmp_path, rows)
    table = pq.read_table(file).to_pydict()
    assert table["brain.parameters.gain"] == ["0.5", "1 mV"]
    assert table["seed"] == [7, 8]
    assert table["passed"] == [True, None]
