"""nrp map: what a brain backend says about a network, as text, JSON and a page."""

import json
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

Nrp = Callable[..., Any]

SCRIPT = """
import pyNN.nest as sim

sim.setup()
source = sim.Population(3, sim.SpikeSourcePoisson(rate=20.0), label="source")
circuit = sim.Population(5, sim.IF_cond_alpha(), label="<circuit>")
for label, weight in (("strong", 50.0), ("weak", 1e-7)):
    synapse = sim.StaticSynapse(weight=weight, delay=1.0)
    sim.Projection(source, circuit, sim.AllToAllConnector(), synapse, label=label)
"""


@pytest.fixture
def lossy(experiment: Path) -> Path:
    """The experiment with a brain whose weights no machine of 16 bits can hold side by side."""
    script = experiment / "brain.py"
    script.write_text(SCRIPT)
    return experiment


def test_text_says_what_is_needed_and_what_is_lost(nrp: Nrp, lossy: Path) -> None:
    done = nrp("map", lossy, "--brain", "spinnaker")
    assert done.code == 0
    assert "8 neurons, 30 synapses" in done.out
    assert "On the SpiNNaker machine" in done.out
    assert "15 of 15 weights become 0" in " ".join(done.out.split())


def test_json_holds_every_number(nrp: Nrp, lossy: Path) -> None:
    data = json.loads(nrp("map", lossy, "--brain", "spinnaker", "--json").out)
    assert (data["brain"], data["neurons"], data["synapses"]) == ("spinnaker", 8, 30)
    machine, kept = data["reports"]
    assert machine["facts"]["application_cores"] == 2
    assert [row["vanished"] for row in kept["tables"]["projections"]] == [0, 15]
    assert kept["warnings"][0]["subject"] == "weak"


class Page(HTMLParser):
    """What a browser would have to fetch, and which elements there are."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.fetched: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.fetched += [str(value) for name, value in attrs if name in ("src", "href")]
        if tag != "meta":
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_stands_alone_and_is_whole(nrp: Nrp, lossy: Path, tmp_path: Path) -> None:
    target = tmp_path / "map.html"
    assert nrp("map", lossy, "--brain", "spinnaker", "--html", target).code == 0
    text = target.read_text("utf-8")
    page = Page(text)
    assert (page.open, page.fetched) == ([], [])
    assert "&lt;circuit&gt;" in text
    assert "15 of 15 weights become 0" in text


def test_a_page_that_cannot_be_written_is_a_usage_error_before_the_brain_is_built(
    nrp: Nrp, lossy: Path, tmp_path: Path, golden: Golden
) -> None:
    (lossy / "brain.py").write_text("1 / 0\n")
    done = nrp("map", lossy, "--brain", "spinnaker", "--html", tmp_path / "nowhere" / "map.html")
    assert done.code == 2
    golden(done.err)


def test_an_experiment_whose_brain_reports_nothing_is_mapped_by_the_one_that_does(
    nrp: Nrp, lossy: Path, golden: Golden
) -> None:
    done = nrp("map", lossy)
    assert done.code == 0
    assert "on spinnaker" in done.out
    golden(done.err)


def test_a_brain_that_reports_nothing_is_an_error_when_it_is_asked_for(
    nrp: Nrp, lossy: Path, golden: Golden
) -> None:
    done = nrp("map", lossy, "--brain", "event")
    assert done.code == 3
    assert "'event'" in done.err
    golden(done.err)


def test_a_wrong_brain_script_is_reported_with_its_place(nrp: Nrp, lossy: Path) -> None:
    (lossy / "brain.py").write_text("raise ValueError('no')")
    done = nrp("map", lossy, "--brain", "spinnaker")
    assert done.code == 3
    assert "brain.py:1: ValueError: no" in done.err


def test_validation_reports_which_weights_would_be_destroyed(nrp: Nrp, lossy: Path) -> None:
    done = nrp("validate", lossy, "--brain", "spinnaker", "--json")
    data = json.loads(done.out)
    assert (done.code, data["valid"]) == (0, True)
    (finding,) = [finding for finding in data["findings"] if finding["code"] == "NRP217"]
    assert finding["level"] == "warning"
    assert "projection 'weak': 15 of 15 weights become 0" in finding["message"]


def test_a_run_reports_it_once(nrp: Nrp, lossy: Path) -> None:
    done = nrp("run", lossy, "--brain", "spinnaker", "--until", "20 ms", "--json")
    problems = json.loads(done.out)["problems"]
    (problem,) = [each for each in problems if "weights become 0" in each["message"]]
    assert done.err.count("weights become 0") == 0
    assert problem["path"].endswith("experiment.yaml")
    shown = nrp("run", lossy, "--brain", "spinnaker", "--until", "20 ms")
    assert (shown.out + shown.err).count("weights become 0") == 1
