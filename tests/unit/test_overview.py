"""The line and the table that shells and notebooks show of an object."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from lxml import html

from nrp_core._support.overview import Overview
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.network.data import Network, Population
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.recording import Recording


def cells(shown: Overview) -> list[list[str]]:
    """Return the cells of the table of a notebook."""
    table = html.fromstring(shown._repr_html_())
    return [[cell.text_content() for cell in row] for row in table.iter("tr")]


def test_a_large_network_is_one_line_in_a_shell() -> None:
    parameters = {"rate": np.ones(100_000), "start": np.zeros(100_000), "duration": np.ones(100_000)}
    population = Population("many", 100_000, "SpikeSourcePoisson", parameters)
    assert repr(Network({"many": population})) == (
        "<Network of 100000 cells in 1 population, with 0 synapses in 0 projections>"
    )


def test_a_table_has_no_more_rows_than_one_can_read() -> None:
    class Long(Overview):
        def _overview(self) -> Any:
            return "with <many> rows", [("n",), *((n,) for n in range(1000))]

    rows = cells(Long())
    assert (rows[0], rows[1], rows[50], rows[51:]) == (["n"], ["0"], ["49"], [["..."]])
    assert "&lt;many&gt;" in Long()._repr_html_()


def test_everything_that_users_hold_has_a_table(fakes: None, drive_to_the_wall: Path, tmp_path: Path) -> None:
    experiment = load_experiment(drive_to_the_wall)
    with Run(experiment) as run:
        folder = RecordingFolder(run, tmp_path / "recording")
        run.run()
        folder.close("finished")
        shown = (experiment, run, run.brain.network, run.plan.scene, run.result(), run.brain, run.world)
        lines = repr(run.brain), repr(run.world)
    tables = [cells(one) for one in (*shown, Recording(tmp_path / "recording"))]
    assert all(len(table) > 1 for table in tables)
    assert ["husky", *tables[3][-1][1:]] == tables[3][-1]
    assert [line.rpartition(" at ")[2] for line in lines] == ["3000 ms>", "3 s>"]
    assert ["arrives", "met", "1.00 m after 1.51 s"] in tables[4]
