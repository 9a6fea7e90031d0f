"""Recordings in NWB and SONATA, read by the programs that they are for."""

import sys
from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from recording_fixtures import STEPS

from nrp_core.errors import BackendLoadError, ExperimentError
from nrp_core.recording import Recording
from nrp_core.recording.export import export


def test_the_inspector_of_dandi_has_no_critical_finding(recorded_drive: Recording, tmp_path: Path) -> None:
    from nwbinspector import Importance, inspect_nwbfile, load_config

    (path,) = export(recorded_drive, "nwb", tmp_path / "out.nwb")
    found = inspect_nwbfile(
        nwbfile_path=path, config=load_config("dandi"), importance_threshold=Importance.CRITICAL
    )
    assert [str(message) for message in found] == []


def test_nwb_is_valid_and_read_by_neo(recorded_drive: Recording, tmp_path: Path) -> None:
    import pynwb
    from neo.io import NWBIO

    (path,) = export(recorded_drive, "nwb", tmp_path / "out.nwb")
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


def test_sonata_is_read_by_libsonata(recorded_drive: Recording, tmp_path: Path) -> None:
    import libsonata

    folder = tmp_path / "out"
    export(recorded_drive, "sonata", folder)
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


@pytest.mark.parametrize("kind", ["nwb", "sonata"])
def test_a_cut_recording_is_exported_up_to_the_cut(
    recorded_drive: Recording, tmp_path: Path, kind: str
) -> None:
    whole = recorded_drive.file.read_bytes()
    for part in range(5):
        recorded_drive.file.write_bytes(whole[: len(whole) * part // 4 - 1] if part else b"")
        name = f"{part}.nwb" if kind == "nwb" else str(part)
        assert export(Recording(recorded_drive.folder), kind, tmp_path / name)


def test_a_missing_package_is_named_with_what_installs_it(
    recorded_drive: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.setitem(sys.modules, "pynwb", None)
    with golden.raises(BackendLoadError, match=r"'nrp-formats\[nwb\]'"):
        export(recorded_drive, "nwb", tmp_path / "out.nwb")
    assert not (tmp_path / "out.nwb").exists()
    with golden.raises(ExperimentError, match=r"'out\.h5'"):
        export(recorded_drive, "nwb", tmp_path / "out.h5")
