"""Recordings in other formats, read by the programs that they are for."""

import builtins
import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import CapabilityError, ExperimentError
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.recording.export import Format, export
from nrp_core.recording.layout import RUN_NAME
from nrp_core.recording.recording import Recording
from nrp_core.recording.sealing import seal

STEPS = 10


@pytest.fixture
def recording(rig: Any) -> Recording:
    for _ in range(STEPS):
        rig.step()
    rig.world.advertise("/wall/body/glass/color").publish(ColorRGBA(1.0))
    rig.recorder.step()
    rig.recorder.close()
    run = {
        "experiment": "driving", "recorded": "2026-01-02T03:04:05+00:00", "seed": 3,
        "brain": {
            "backend": "mock",
            "populations": {"eyes": {"size": 3, "cell_type": "c"}, "wheels": {"size": 2, "cell_type": "c"}},
            "views": {"left": {"eyes": [[0, 1]], "wheels": [[0, 1]]}, "seeing": {"eyes": [[0, 2]]}},
        },
        "settings": {"timestep": 20_000_000, "description": "a drive"},
    }  # fmt: skip
    (rig.folder / RUN_NAME).write_bytes(seal(run))
    return Recording(rig.folder)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_tables_hold_every_spike_and_every_number(recording: Recording, tmp_path: Path) -> None:
    files = {path.name: rows(path) for path in export(recording, Format.CSV, tmp_path / "out")}
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
    recording: Recording, tmp_path: Path
) -> None:
    import pandas as pd

    export(recording, Format.CSV, tmp_path / "out")
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


def test_the_inspector_of_dandi_has_no_critical_finding(recording: Recording, tmp_path: Path) -> None:
    from nwbinspector import Importance, inspect_nwbfile, load_config

    (path,) = export(recording, Format.NWB, tmp_path / "out.nwb")
    found = inspect_nwbfile(
        nwbfile_path=path, config=load_config("dandi"), importance_threshold=Importance.CRITICAL
    )
    assert [str(message) for message in found] == []


def test_nwb_is_valid_and_read_by_neo(recording: Recording, tmp_path: Path) -> None:
    import pynwb
    from neo.io import NWBIO

    (path,) = export(recording, Format.NWB, tmp_path / "out.nwb")
    assert pynwb.validate(path=str(path)) == []
    with pynwb.NWBHDF5IO(path, "r") as file:
        nwb = file.read()
        assert nwb.session_description == "driving"
        units = nwb.units.to_dataframe()
        assert units["population"].tolist() == ["eyes"] * 3 + ["wheels"] * 2
        assert units["groups"].tolist() == ["left seeing", "seeing", "", "left", ""]
        assert [len(times) for times in units["spike_times"]] == [STEPS, 0, 0, 0, STEPS]
        assert nwb.units.resolution > 0
        assert nwb.subject.species.endswith("NCBITaxon_32644")  # "unidentified"
        np.testing.assert_allclose(units["spike_times"][0][:2], [0.0145, 0.0345])
        place = nwb.processing["behavior"]["Position"]["husky"]
        assert place.data.shape == (STEPS + 1, 3)
        assert (place.starting_time, place.rate, place.timestamps) == (0.0, 50.0, None)
        assert nwb.acquisition["husky.camera.compressed"].data.shape[1:] == (2, 2, 3)
        assert nwb.acquisition["brain.devices.steer.left.voltage"].unit == "mV"
        assert "husky.cmd_vel" in nwb.processing["commands"].data_interfaces
    reader = NWBIO(str(path), mode="r")
    (block,) = reader.read_all_blocks()
    trains = block.segments[0].spiketrains
    assert sorted(len(train) for train in trains) == [0, 0, 0, STEPS, STEPS]
    reader._io_nwb.close()


def test_sonata_is_read_by_libsonata(recording: Recording, tmp_path: Path) -> None:
    import libsonata

    folder = tmp_path / "out"
    export(recording, Format.SONATA, folder)
    spikes = libsonata.SpikeReader(str(folder / "spikes.h5"))
    assert sorted(spikes.get_population_names()) == ["eyes", "wheels"]
    assert spikes["eyes"].get()[:2] == [(0, 14.5), (0, 34.5)]
    report = libsonata.SomaReportReader(str(folder / "devices.h5"))["devices"]
    values = report.get()
    assert report.times[2] == 20.0
    assert values.data.shape == (STEPS + 1, 1)
    assert values.data[-1, 0] != values.data[1, 0]
    sets = libsonata.NodeSets.from_file(str(folder / "node_sets.json"))
    assert sets.names == {"eyes", "wheels", "left", "left.eyes", "left.wheels", "seeing"}


@pytest.mark.parametrize("kind", list(Format))
def test_a_cut_recording_is_exported_up_to_the_cut(
    recording: Recording, tmp_path: Path, kind: Format
) -> None:
    whole = recording.file.read_bytes()
    for part in range(5):
        recording.file.write_bytes(whole[: len(whole) * part // 4 - 1] if part else b"")
        name = f"{part}.nwb" if kind is Format.NWB else str(part)
        assert export(Recording(recording.folder), kind, tmp_path / name)


def test_nothing_is_overwritten_and_names_are_checked(
    recording: Recording, tmp_path: Path, golden: Golden
) -> None:
    (tmp_path / "there").mkdir()
    with golden.raises(ExperimentError):
        export(recording, Format.CSV, tmp_path / "there")
    with golden.raises(ExperimentError):
        export(recording, Format.CSV, tmp_path / "nowhere" / "out")
    with golden.raises(ExperimentError, match=r"'out\.h5'"):
        export(recording, Format.NWB, tmp_path / "out.h5")


def test_a_missing_package_is_named_with_what_installs_it(
    recording: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    real = builtins.__import__

    def without(name: str, *args: Any, **kwargs: Any) -> Any:
        if name.startswith("nrp_core.recording.export.nwb"):
            raise ModuleNotFoundError("No module named 'pynwb'", name="pynwb")
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with golden.raises(CapabilityError, match=r"'nrp-core\[export\]'"):
        export(recording, Format.NWB, tmp_path / "out.nwb")
