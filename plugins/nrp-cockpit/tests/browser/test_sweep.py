"""The folder of a sweep is shown in a page, which follows it while it grows."""

from __future__ import annotations

import csv
import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from statistics import mean, stdev
from typing import Any

import pytest
from browsing import Watched, running, seen
from nrp_lab.sweep import sweep
from playwright.sync_api import expect
from visitors import RefusedError, visit

from nrp_core.experiment.reading.find import load_experiment

SWEEP: dict[str, Any] = {
    "experiment": "braitenberg_husky",
    "settings": {"world.options.image_scale": 0.25, "world.robots.husky.pose": [0, 0.1, 0.2, 0, 0, 0]},
    "vary": {"brain.options.tolerance": [1e-6, 1e-4], "seed": {"from": 1, "to": 2}},
    "measure": ["distance"],
    "until": "200 ms",
}
MEASURE = "distance.husky"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep of which half the runs have been made."""
    folder = tmp_path_factory.mktemp("sweeps") / "tolerance.sweep"
    sweep(SWEEP, folder, workers=1, only=["seed=1"])
    return folder


@pytest.fixture(scope="module")
def address(folder: Path) -> Iterator[str]:
    """The address of its page."""
    with running() as cockpits:
        yield cockpits.open(str(folder))


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "results.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_sweep_is_shown_grows_and_opens_its_runs(folder: Path, address: str, watched: Watched):
    assert address.endswith("#/sweep")
    page = watched.open(address.partition("#")[0], 1280, 720, ready=("region", "Progress"))
    progress = page.get_by_role("region", name="Progress")
    expect(progress).to_contain_text("2 of 4 runs")
    expect(page.get_by_role("img", name=MEASURE, exact=False)).to_be_visible()
    sweep(SWEEP, folder, workers=1)  # somebody goes on with it
    expect(progress).to_contain_text("4 of 4 runs")
    made = rows(folder)
    combinations = page.get_by_role("region", name="Combinations")
    for text, tolerance in (("1e-6", "1e-06"), ("1e-4", "0.0001")):
        of_both = [float(row[MEASURE]) for row in made if row["brain.options.tolerance"] == tolerance]
        cell = combinations.get_by_role("row").filter(has_text=text).get_by_role("cell").last
        shown = seen(page, cell.inner_text, lambda text: " ± " in text)  # of one run there is no deviation
        middle, spread = map(float, shown.split(" ± "))
        assert middle == pytest.approx(mean(of_both), rel=1e-3)
        assert spread == pytest.approx(stdev(of_both), rel=0.05)
    runs = page.get_by_role("region", name="Table of runs")
    head = runs.get_by_role("columnheader", name=MEASURE)
    for order in ("ascending", "descending"):
        head.get_by_role("button").click()
        expect(head).to_have_attribute("aria-sort", order)
    farthest = max(made, key=lambda row: float(row[MEASURE]))
    first = runs.get_by_role("row").nth(1)
    expect(first.get_by_role("button")).to_have_text(farthest["run"])
    first.get_by_role("button").click()
    words = shlex.split(page.get_by_role("region", name="Selected run").get_by_role("code").inner_text())
    assert words[:3] == ["nrp", "cockpit", "braitenberg_husky"]
    opened = load_experiment(words[2], words[4::2])
    assert opened.seed == int(farthest["seed"])
    assert opened.brain.options["tolerance"] == float(farthest["brain.options.tolerance"])
    assert opened.world.options["image_scale"] == 0.25
    page.get_by_role("radio", name="Errors").click()
    expect(page.get_by_text("There is no such run.")).to_be_visible()
    page.set_viewport_size({"width": 640, "height": 360})  # 200 % of 1280x720
    seen(page, lambda: page.evaluate("() => document.documentElement.scrollWidth <= innerWidth"))


def test_impossible_views_of_a_sweep_are_refused_with_the_reason(folder: Path, address: str):
    with visit(address) as visitor:
        for service, given, reason in (
            ("sweep/runs", {"sort": "seeed"}, "there is no column 'seeed'; did you mean 'seed'?"),
            ("sweep/runs", {"choice": "pased"}, "there is no choice 'pased'; did you mean 'passed'?"),
            ("sweep/figure", {"measure": "distance.huski"}, "did you mean 'distance.husky'?"),
            ("sweep/figure", {"kind": "heat"}, "a heat map needs 2 varying settings"),
        ):
            with pytest.raises(RefusedError, match=re.escape(reason)):
                visitor.call(service, **given)
        visitor.subscribe("/cockpit/sweep")
        about = folder / "sweep.json"
        about.write_text(json.dumps(json.loads(about.read_text()) | {"runs": 6}))
        assert visitor.until(lambda: (visitor.last("sweep") or {}).get("runs") == 6)
