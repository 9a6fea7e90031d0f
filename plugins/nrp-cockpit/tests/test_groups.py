"""The groups of cells that the page draws, and the synapses between them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from large_brain import large_brain
from nrp_cockpit.session import groups
from nrp_cockpit.session.groups import connections, groups_data

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run


def test_each_cell_is_drawn_in_its_smallest_group():
    views = {
        "left": {"brain": [[0, 3]]},
        "right": {"brain": [[3, 5], [8, 9]]},
        "both": {"brain": [[0, 5], [8, 9]]},
        "again": {"brain": [[0, 3]]},
        "some": {"brain": [[4, 12]], "few": [[0, 2]]},
        "everything": {"brain": [[0, 20]]},
        "few_again": {"few": [[0, 16]]},
    }
    found = {one["name"]: one["own"] for one in groups_data(views, {"brain": 20, "few": 16})}
    assert found == {
        "left": {"brain": [[0, 3]]},
        "right": {"brain": [[3, 5], [8, 9]]},
        "both": {},
        "again": {},
        "some": {"brain": [[5, 8], [9, 12]]},
    }


def test_synapses_between_groups_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    with Run(load_experiment(large_brain(tmp_path, cells=80, packets=1))) as run:
        network = run.brain.network
        found = connections(network)
        monkeypatch.setattr(groups, "MOST_SYNAPSES", 100)
        assert connections(network) == {"parts": None, "links": None}
    named = {(one["population"], one["group"]): at for at, one in enumerate(found["parts"])}
    sizes = {("ring", "east"): 10, ("ring", "west"): 10, ("ring", "marked"): 20}
    assert set(named) >= {*sizes, ("ring", None), ("kicks", None)}
    cells = np.zeros(80, int) + named["ring", None]
    cells[:20], cells[:10], cells[40:50] = (
        named["ring", "marked"],
        named["ring", "east"],
        named["ring", "west"],
    )
    expected: dict[tuple[int, int], int] = {}
    for cell in range(80):
        for step in range(1, 5):
            pair = int(cells[cell]), int(cells[(cell + step) % 80])
            expected[pair] = expected.get(pair, 0) + 1
    links = [link for link in found["links"] if link["projection"] == "next"]
    assert {(link["from"], link["to"]): link["synapses"] for link in links} == expected
    assert {link["weight"] for link in found["links"]} == {6.0, 40.0}
