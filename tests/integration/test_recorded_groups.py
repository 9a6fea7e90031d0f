"""The devices of ``map_neurons`` are recorded each by itself, and read as one table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import nrp_core
from nrp_core.recording.export import export
from nrp_core.recording.recording import Recording

PULLS, SIDES = "/brain/devices/turn/pulls", "/brain/devices/see/sides"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Four groups of muscles and of cells of a retina."""
    folder = tmp_path_factory.mktemp("groups") / "gaze"
    nrp_core.run("following_head", until_s=0.4, record=folder, images="off")
    return Recording(folder)


@pytest.mark.parametrize("group", [PULLS, SIDES])
def test_a_group_is_a_table_with_a_column_for_each_device(recording: Recording, group: str) -> None:
    whole = recording.frame(f"{group}/*/rate")
    assert list(whole.columns) == ["0", "1", "2", "3"]
    assert set(whole.attrs["units"].values()) == {"Hz"}
    assert whole.index.is_monotonic_increasing
    for number in whole.columns:
        one = recording.frame(f"{group}/{number}/rate").iloc[:, 0]
        one = one[~one.index.duplicated(keep="last")]
        np.testing.assert_array_equal(whole[number][one.index], one)
        held = whole[number].loc[~whole.index.isin(one.index)]
        assert (held == one.reindex(held.index, method="ffill")).all()


def test_a_group_is_one_file_of_an_export(recording: Recording, tmp_path: Path) -> None:
    files = {path.name: path for path in export(recording, "csv", tmp_path / "csv")}
    table = pd.read_csv(files["brain.devices.turn.pulls.rate.csv"], index_col="time_s")
    assert list(table.columns) == [f"{number} [Hz]" for number in range(4)]
    np.testing.assert_array_equal(table, recording.frame(f"{PULLS}/*/rate"))
    assert len([name for name in files if "pulls" in name or "sides" in name]) == 2
