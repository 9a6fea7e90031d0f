"""Recordings in other formats, read by the programs that they are for."""

import csv
from pathlib import Path

import pytest
from experiment_fixtures import Install
from golden import Golden
from recording_fixtures import STEPS

from nrp_core.errors import BackendLoadError, ExperimentError, UnknownBackendError
from nrp_core.recording.export import EXPORTERS, export
from nrp_core.recording.recording import Recording
from nrp_core.registry import OPTIONAL


def rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_tables_hold_every_spike_and_every_number(recorded_drive: Recording, tmp_path: Path) -> None:
    files = {path.name: rows(path) for path in export(recorded_drive, "csv", tmp_path / "out")}
    spikes = files["spikes.csv"]
    assert len(spikes) == 2 * STEPS
    assert spikes[0] == {"time_ms": "14.5", "population": "eyes", "neuron": "0"}
    assert spikes[-1] == {"time_ms": "200.0", "population": "wheels", "neuron": "1"}
    poses = files["gazebo.model_states.husky.csv"]
    assert len(poses) == STEPS + 1
    assert float(poses[-1]["x [m]"]) == pytest.approx(0.09, abs=0.01)
    assert {row["linear.x [m/s]"] for row in files["husky.cmd_vel.csv"]} == {"0.5"}
    assert len(files["brain.devices.steer.left.voltage.csv"]) == STEPS
    assert files["wall.body.glass.color.csv"][0]["r"] == "1.0"


def test_headers_of_tables_have_units_and_pandas_reads_the_numbers(
    recorded_drive: Recording, tmp_path: Path
) -> None:
    import pandas as pd

    export(recorded_drive, "csv", tmp_path / "out")
    command = pd.read_csv(tmp_path / "out" / "husky.cmd_vel.csv", index_col="time_s")
    assert list(command) == [
        *(f"linear.{axis} [m/s]" for axis in "xyz"), *(f"angular.{axis} [rad/s]" for axis in "xyz")
    ]  # fmt: skip
    assert command.dtypes.eq(float).all()
    assert list(pd.read_csv(tmp_path / "out" / "gazebo.model_states.husky.csv", index_col="time_s")) == [
        "x [m]", "y [m]", "z [m]", "qx", "qy", "qz", "qw",
        "vx [m/s]", "vy [m/s]", "vz [m/s]", "wx [rad/s]", "wy [rad/s]", "wz [rad/s]",
    ]  # fmt: skip
    voltage = pd.read_csv(tmp_path / "out" / "brain.devices.steer.left.voltage.csv", index_col="time_s")
    assert list(voltage) == ["data [mV]"]


def test_a_cut_recording_is_exported_up_to_the_cut(recorded_drive: Recording, tmp_path: Path) -> None:
    whole = recorded_drive.file.read_bytes()
    for part in range(5):
        recorded_drive.file.write_bytes(whole[: len(whole) * part // 4 - 1] if part else b"")
        assert export(Recording(recorded_drive.folder), "csv", tmp_path / str(part))


def test_nothing_is_overwritten(recorded_drive: Recording, tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "mine.txt").touch()
    with golden.raises(ExperimentError):
        export(recorded_drive, "csv", tmp_path / "there")
    with golden.raises(ExperimentError):
        export(recorded_drive, "csv", tmp_path / "nowhere" / "out")


COUNTER = """
from nrp_core.recording import Exporter, Numbers

def write(recording, path):
    counts = {label: len(ids) for label, (ids, _) in Numbers.of(recording).spikes.items()}
    path.write_text(str(counts))
    if "full" in path.name:
        raise OSError(28, "No space left on device")
    return [path]

COUNTS = Exporter(write, ".txt")
NONE = write
"""
ENTRY_POINTS = "[nrp_core.exporters]\ncounts = lab_counts:COUNTS\nwrong = lab_counts:NONE\n"


@pytest.mark.usefixtures("site")
def test_the_format_of_a_package_is_written_and_its_suffix_demanded(
    recorded_drive: Recording, install: Install, tmp_path: Path, golden: Golden
) -> None:
    install("lab_counts", ENTRY_POINTS, COUNTER)
    (file,) = export(recorded_drive, "counts", tmp_path / "out.txt")
    assert file.read_text() == f"{{'eyes': {STEPS}, 'wheels': {STEPS}}}"
    with golden.raises(ExperimentError, match=r"'out\.csv'"):
        export(recorded_drive, "counts", tmp_path / "out.csv")
    with golden.raises(ExperimentError, match="No space left"):
        export(recorded_drive, "counts", tmp_path / "full.txt")
    assert not (tmp_path / "full.txt").exists()
    with golden.raises(BackendLoadError, match=r"'wrong'.*lab_counts 1\.0"):
        export(recorded_drive, "wrong", tmp_path / "out.txt")


def test_a_format_that_is_not_installed_is_named_with_its_distribution(
    recorded_drive: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(OPTIONAL, "acme-formats", {EXPORTERS.group: ["edf"]})
    with pytest.raises(UnknownBackendError, match="'edf' is in acme-formats, which is not installed"):
        export(recorded_drive, "edf", tmp_path / "out.edf")
