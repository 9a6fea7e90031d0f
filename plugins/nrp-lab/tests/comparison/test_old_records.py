"""A run beside the CSV files of an older one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_lab.comparison.old_records import RecordsDiff, is_records, tolerances_of
from nrp_lab.comparison.report import records_headline

from nrp_core.errors import ExperimentError


def write(path: Path, times: np.ndarray, **columns: np.ndarray) -> None:
    path.parent.mkdir(exist_ok=True)
    rows = zip(times.tolist(), *(each.tolist() for each in columns.values()), strict=True)
    lines = [",".join(["time", *columns, "Simulation_reset"]), *(",".join(map(str, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n")


@pytest.fixture
def both(tmp_path: Path) -> tuple[Path, Path]:
    """A sine sampled every 20 ms, and an older one every 40 ms, which starts later and is 0.01 larger."""
    one, old = np.arange(0.0, 2.0, 0.02), np.arange(0.1, 2.0, 0.04)
    write(tmp_path / "new" / "eye.csv", one, angle=np.sin(one), still=np.zeros(len(one)))
    write(tmp_path / "old" / "eye.csv", old, angle=np.sin(old) + 0.01, still=np.zeros(len(old)))
    return tmp_path / "new", tmp_path / "old"


def test_each_column_is_compared_at_the_old_times_that_both_have(both: tuple[Path, Path]) -> None:
    found = RecordsDiff.of(*both, {})
    signals = {one.name: one for one in found.signals}
    assert set(signals) == {"eye.csv/angle", "eye.csv/still"}
    angle = signals["eye.csv/angle"]
    assert (angle.times[0], angle.times[-1]) == (0.1, pytest.approx(1.98))
    assert angle.largest == pytest.approx(0.01)
    assert angle.rms == pytest.approx(0.01)
    assert angle.tolerance == pytest.approx(0.05 * np.ptp(angle.old))
    assert found.agrees
    assert not RecordsDiff.of(*both, {"eye.csv/angle": 0.009}).agrees
    assert RecordsDiff.of(*both, {"eye.csv": 0.011}).agrees


def test_what_cannot_be_compared_is_named(both: tuple[Path, Path]) -> None:
    assert not RecordsDiff.of(*both, {}).missing
    run, old = both[0] / "eye.csv", both[1] / "eye.csv"
    (both[1] / "arm.csv").write_text("time,x\n0,1\n")
    old.write_text(old.read_text().replace("still", "moving") + "3.0,0.0,0.0,\n")
    run.write_text(run.read_text().replace("\n1.5,", "\n1.5,none"))
    found = RecordsDiff.of(*both, {})
    assert not found.agrees
    for reason, word in zip(
        found.missing, ("arm.csv", "eye.csv/moving", "ended at 1.98", "1 of 48"), strict=True
    ):
        assert word in reason
    assert [word for word in ("still", "started at 0.1") if word in " ".join(found.beyond)] == [
        "still",
        "started at 0.1",
    ]
    assert records_headline(found).startswith("Not all old records were compared")
    with pytest.raises(ExperimentError, match="angel"):
        RecordsDiff.of(*both, {"eye.csv/angel": 1.0})
    with pytest.raises(ExperimentError):
        RecordsDiff.of(both[0] / "none", both[1], {})


@given(
    st.lists(st.sampled_from([0.0, 0.1, 0.2, 0.3]), min_size=2, max_size=20),
    st.lists(st.sampled_from([0.0, 0.1, 0.2, 0.3]), min_size=2, max_size=20),
)
def test_rows_of_equal_times_are_counted(
    tmp_path_factory: pytest.TempPathFactory, one: list[float], old: list[float]
) -> None:
    folder = tmp_path_factory.mktemp("spikes")
    write(folder / "one" / "s.csv", np.array([*one, one[0]]), cell=np.full(len(one) + 1, 2))
    write(folder / "old" / "s.csv", np.array([*old, old[0]]), cell=np.full(len(old) + 1, 3))
    rows, cells = RecordsDiff.of(folder / "one", folder / "old", {}).signals
    assert (rows.name, cells.name) == ("s.csv/rows", "s.csv/cell")
    for i, t in enumerate(rows.times):
        assert rows.one[i] == sum(each <= t for each in [*one, one[0]])
        assert rows.old[i] == sum(each <= t for each in [*old, old[0]])
    assert np.allclose(cells.one, 2 * rows.one)
    assert np.allclose(cells.old, 3 * rows.old)


def test_texts_are_compared_by_their_rows(tmp_path: Path) -> None:
    for name, rows in (("one", ["0,a", "1,b", "1,b"]), ("old", ["0,a", "1,b", "1,a"])):
        (tmp_path / name).mkdir()
        for end, lines in (("s", rows), ("t", rows[:2] if name == "old" else ["0,b", "1,b"])):
            (tmp_path / name / f"{end}.csv").write_text("\n".join(["time,text", *lines]))
    found = {each.name: each for each in RecordsDiff.of(tmp_path / "one", tmp_path / "old", {}).signals}
    assert {name: each.largest for name, each in found.items()} == {
        "s.csv/rows": 0.0, "s.csv/text=a": 1.0, "s.csv/text=b": 1.0, "t.csv/text=b": 1.0,
    }  # fmt: skip
    same = RecordsDiff.of(tmp_path / "one", tmp_path / "one", {})
    assert same.agrees
    assert not same.missing


def test_events_without_numbers_and_after_the_end_are_named(tmp_path: Path) -> None:
    header = "time,text,given"
    for name, rows in (
        ("one", ["0,nan,1", "1,nan,", "1,nan,1"]),
        ("old", ["0,nan,1", "1,nan,1", "1,nan,1", "9,nan,1"]),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "s.csv").write_text("\n".join([header, *rows]))
    found = RecordsDiff.of(tmp_path / "one", tmp_path / "old", {})
    for reason, word in zip(found.missing, ("s.csv/text' has no numbers", "2 of 3"), strict=True):
        assert word in reason
    assert "run ended at 1" in " ".join(found.beyond)


def test_the_command_reports_in_a_page_and_its_exit_code(
    nrp: Any, both: tuple[Path, Path], tmp_path: Path
) -> None:
    page = tmp_path / "page.html"
    done = nrp("diff", *both, "--html", page, "--json")
    assert done.code == 0
    assert json.loads(done.out)["signals"]["eye.csv/angle"]["agrees"] is True
    assert "<svg" in page.read_text()
    assert nrp("diff", *both, "--margin", "eye.csv/angle=0.001").code == 1
    assert nrp("diff", *(folder / "eye.csv" for folder in both)).code == 0
    assert nrp("diff", *both, "--seeds", 3).code == 2
    assert nrp("diff", *both, "--margin", "eye.csv").code == 2


def test_recordings_are_no_old_records(tmp_path: Path) -> None:
    (tmp_path / "csv").mkdir()
    assert not is_records(tmp_path / "csv")
    (tmp_path / "csv" / "a.csv").write_text("t\n0\n")
    assert is_records(tmp_path / "csv")
    assert is_records(tmp_path / "csv" / "a.csv")
    (tmp_path / "csv" / "run.json").write_text("{}")
    assert not is_records(tmp_path / "csv")
    for wrong in ("eye.csv", "=1", "eye.csv=-1", "eye.csv=wide"):
        with pytest.raises(ValueError, match="FILE"):
            tolerances_of([wrong])
