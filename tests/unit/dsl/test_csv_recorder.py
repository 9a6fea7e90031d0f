"""Rows become files that any reader of CSV reads back as they were."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

import nrp_core.dsl as nrp
from nrp_core.dsl.mappings import CSVRecorder, write_csv
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.errors import OutsideFolderError, TransferFunctionError

CELLS = st.text(
    st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"], include_characters=',"\n'), min_size=1
)


def bound(erase: bool = False, filename: str = "rows.csv") -> nrp.TransferFunction:
    @nrp.MapCSVRecorder("rows", filename, ["time", "a, b"], erase)
    @nrp.Robot2Neuron()
    def record(t, rows):  # type: ignore[no-untyped-def]
        rows.record_entry(t, "x, y")

    return record.bind(MockBrain({}), MockWorld())


def read(path: Path) -> list[list[str]]:
    with path.open(newline="") as file:
        return list(csv.reader(file))


def test_commas_in_headers_and_cells_are_quoted(tmp_path: Path) -> None:
    function = bound()
    function.run(20_000_000)
    (path,) = write_csv([function], tmp_path)
    assert read(path) == [["time", "a, b"], ["0.02", "x, y"]]


@given(st.lists(st.lists(CELLS, min_size=2, max_size=2), max_size=4))
def test_any_cells_are_read_back_as_they_were(
    tmp_path_factory: pytest.TempPathFactory, rows: list[list[str]]
) -> None:
    function = bound()
    for row in rows:
        function.adapters["rows"].record_entry(*row)  # type: ignore[attr-defined]
    (path,) = write_csv([function], tmp_path_factory.mktemp("csv"))
    assert read(path)[1:] == rows


def test_the_first_row_after_a_reset_is_marked_in_a_column_of_its_own(tmp_path: Path) -> None:
    function = bound()
    function.run(0)
    function.reset()
    function.run(0)
    function.run(20_000_000)
    (path,) = write_csv([function], tmp_path)
    header, before, first, second = read(path)
    assert header[-1] == "Simulation_reset"
    assert [row[2:] for row in (before, first, second)] == [[], ["RESET"], []]


def test_a_reset_can_forget_the_rows() -> None:
    function = bound(erase=True)
    function.run(0)
    function.reset()
    recorder = function.adapters["rows"]
    assert isinstance(recorder, CSVRecorder)
    assert recorder.rows == []


def test_recorders_of_one_file_share_its_headers(tmp_path: Path) -> None:
    one, other = bound(), bound()
    one.run(0)
    other.run(20_000_000)
    (path,) = write_csv([one, other], tmp_path)
    assert [row[0] for row in read(path)] == ["time", "0.0", "0.02"]


@pytest.mark.parametrize("name", ["../../rows.csv", "/rows.csv"])
def test_a_file_outside_the_folder_of_the_run_is_refused(name: str) -> None:
    with pytest.raises(OutsideFolderError):
        bound(filename=name)


def test_a_file_needs_a_name(golden: Golden) -> None:
    with golden.raises(TransferFunctionError, match="'rows'.*''"):
        nrp.MapCSVRecorder("rows", "", ["a"])
