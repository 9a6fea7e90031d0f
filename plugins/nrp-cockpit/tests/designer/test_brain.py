"""Populations and projections are drawn, and write the PyNN script that runs."""

from __future__ import annotations

import ast
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest
from brains import Artist, draw_the_brain_of_the_paper
from golden import Golden
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from nrp_bibi.model.metamodel import Value, concrete, features
from nrp_cockpit.designer.brain.checking import brain_findings
from nrp_cockpit.designer.brain.document import BrainDocument
from nrp_cockpit.designer.brain.graph import network_graph
from nrp_cockpit.designer.brain.model import CELL_CLASSES, SYNAPSE_CLASSES, CellModel, Connector, SynapseModel
from nrp_cockpit.designer.brain.script import read_script, script_of
from nrp_cockpit.designer.tree import walk
from nrp_conformance.brain import kit
from nrp_conformance.brain.kit import SAMPLES
from visitors import RefusedError, cockpit

from nrp_core.errors import ExperimentError
from nrp_core.experiment.reading.find import find_file, load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code
from nrp_core.network.cells import CELLS
from nrp_core.network.rewiring import Neuromodulation
from nrp_core.network.synapses import LAWS

SOME = settings(
    max_examples=10, deadline=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck)
)


@pytest.fixture
def artist(tmp_path: Path) -> Artist:
    return Artist(tmp_path / "drawn.py")


DRIVES = """
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def {}(t):
    return geometry_msgs.msg.Twist()
"""


def test_a_network_that_was_not_drawn_shows_its_other_receptors_by_name() -> None:
    cells = [kit.cells(SAMPLES["IF_curr_exp"], label) for label in ("a", "b")]
    wires = [
        replace(kit.connect("a", "b", weight), label=receptor, receptor=receptor, neuromodulation=reward)
        for receptor, weight, reward in (
            ("excitatory", 0.1, None), ("inhibitory", -0.1, None), ("reward", 0.1, Neuromodulation())
        )
    ]  # fmt: skip
    _, shown = network_graph(kit.network(*cells, *wires))
    assert [(one["kind"], one["label"]) for one in shown] == [
        ("excites", "1 synapse"),
        ("inhibits", "1 synapse"),
        ("excites", "1 synapse (reward)"),
    ]


def test_the_drawn_brain_of_the_paper_drives_the_robot_as_the_written_one(artist: Artist) -> None:
    draw_the_brain_of_the_paper(artist)
    artist.document.save()
    script = artist.document.path
    written = ["duration=2 s", "events.left_red.at=0.5 s", "world.options.image_scale=0.25"]
    drawn = [*written, "brain.populations=null", f"brain.model={script}"]
    ends = []
    for overrides in (drawn, written):
        with Run(load_experiment("braitenberg_husky", overrides)) as run:
            run.run()
            ends.append((run.result().trajectory_digest, run.world.model_motion("husky").pose.position))
    assert ends[0] == ends[1], "the same cells with the same synapses, in other populations"


# -- the script


@st.composite
def _brains(draw: st.DrawFn, path: Path) -> BrainDocument:
    """A brain that somebody could draw: any cells, connectors, synapses and values."""
    artist = Artist(path)
    count = draw(st.integers(1, 3))
    for _ in range(count):
        artist.do("add", path="", field="population")
    for _ in range(draw(st.integers(0, 3))):
        source, target = draw(st.integers(0, count - 1)), draw(st.integers(0, count - 1))
        artist.do("connect", source=f"population/{source}", target=f"into:population/{target}")
    choices = {
        CellModel: list(CELL_CLASSES),
        Connector: list(concrete(Connector)),
        SynapseModel: list(SYNAPSE_CLASSES),
    }
    for base, names in choices.items():
        for path_, node in list(walk(artist.document.brain)):
            if isinstance(node, base):
                artist.do("become", path=path_, type=draw(st.sampled_from(names)))
    for path_, node in list(walk(artist.document.brain)):
        for feature in features(type(node)):
            if isinstance(feature.of, Value) and feature.of.name == "Number" and draw(st.booleans()):
                text = str(draw(st.sampled_from([0, 0.1, 1, 2.5, -61.25, 1e-7, 3e5])))
                with suppress(ExperimentError):  # beyond its limits
                    artist.do("set", path=path_, field=feature.field, text=text)
    return artist.document


@given(data=st.data())
@SOME
def test_a_script_that_was_drawn_is_drawn_again_as_it_was(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    document = data.draw(_brains(tmp_path_factory.mktemp("brains") / "brain.py"))
    document.save()
    again = BrainDocument(document.path)
    assert again.is_drawn
    assert again.brain == document.brain
    assert script_of(again.brain) == document.path.read_text()
    ast.parse(document.text)


@given(at=st.integers(0, 10**6), put=st.sampled_from(["#", " ", "\n", "x", "0", ")"]))
@SOME
def test_a_script_with_any_other_character_is_not_the_designers_or_says_so(
    at: int, put: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    artist = Artist(tmp_path_factory.mktemp("brains") / "brain.py")
    artist.population("cells", 3, tau_m=10)
    artist.projection("population/0", "population/0", 0.5)
    text = artist.document.text
    changed = text[: at % len(text)] + put + text[at % len(text) :]
    brain = read_script(changed)
    assert brain is None or script_of(brain) == changed, "nothing that was written gets lost"


def test_every_cell_synapse_and_parameter_of_the_platform_can_be_drawn() -> None:
    assert set(CELL_CLASSES) == set(CELLS)
    for name, cell in CELLS.items():
        fields = {feature.field for feature in features(CELL_CLASSES[name])}
        assert fields >= {*cell.parameters, *(f"initial_{one}" for one in cell.state)}
    for law in LAWS.values():
        parts = {
            one for classes in law.parts.values() for part in classes.values() for one in part.parameters
        }
        fields = {feature.field for feature in features(SYNAPSE_CLASSES[law.pynn])}
        assert fields >= {"weight", "delay", *law.parts, *(law.parameters.keys() - parts)}


# -- what fits, and what does not


def test_an_invalid_command_is_refused_with_its_reason(artist: Artist, golden: Golden) -> None:
    source = artist.do("add", path="", field="population")
    artist.do("become", path=f"{source}/cells", type="SpikeSourcePoisson")
    cells = artist.population("cells", 3)
    refusals = artist.document.fits(cells)
    assert refusals[f"into:{source}"] == "'population' only emits spikes: it cannot receive synapses"
    assert refusals[f"into:{cells}"] is None, "a population can project to itself"
    for wrong, reason in (
        ({"path": cells, "field": "name", "text": "population"}, "the name 'population' is already in use"),
        ({"path": cells, "field": "name", "text": "sim"}, "'name' cannot be 'sim'"),
        ({"path": cells, "field": "size", "text": "0"}, "a whole number, 1 or more"),
        ({"path": f"{cells}/cells", "field": "tau_m", "text": "-1"}, "it must be a number, more than 0"),
    ):
        with pytest.raises(ExperimentError, match=reason):
            artist.document.do("set", **wrong)
    with golden.raises(ExperimentError):
        artist.do("connect", source=f"into:{cells}", target=f"into:{cells}")


@pytest.mark.heavy
def test_a_new_name_goes_to_the_projections_and_with_a_population_they_go(artist: Artist) -> None:
    one, other = artist.population("one", 3), artist.population("other", 2)
    artist.projection(one, other, 0.1)
    artist.projection(other, other, 0.1)
    artist.set(one, name="first")
    assert artist.document.brain.projection[0].source == "first"
    artist.do("remove", path=one)
    assert [each.name for each in artist.document.brain.projection] == ["other to other"]
    artist.document.undo()
    assert len(artist.document.brain.projection) == 2


def test_cells_beyond_a_population_are_found_at_their_projection(artist: Artist) -> None:
    one = artist.population("one", 3)
    wire = artist.projection(f"{one}[1:9]", one, 0.1)
    (found,) = brain_findings(artist.document.brain, artist.document.path)
    assert found["path"] == wire
    assert found["summary"] == "'one to one': 'one' has 3 cells, so [1:9] is out of range"
    assert artist.document.text.splitlines()[found["line"] - 1] == "sim.Projection("


# -- scripts of people


def test_a_script_of_a_person_is_shown_and_never_overwritten(artist: Artist, golden: Golden) -> None:
    artist.population("cells", 3)
    artist.document.save()
    path = artist.document.path
    path.write_text(other := path.read_text().replace("sim.Population(3", "sim.Population(4"))
    with golden.raises(ExperimentError, match="changed outside"):  # also by another designer
        artist.document.save()
    path.write_text(by_hand := other + "# mine\n")
    shown = BrainDocument(path)
    assert shown.data()["python"]["text"] == by_hand
    assert not shown.data()["is_drawn"]
    artist.population("more", 1)
    for document in (shown, artist.document):
        with golden.raises(ExperimentError):
            document.save()
    with golden.raises(ExperimentError):
        shown.do("add", path="", field="population")
    assert path.read_text() == by_hand


def test_a_text_that_the_designer_would_not_write_says_at_which_line(artist: Artist, golden: Golden) -> None:
    artist.population("cells", 3)
    artist.document.write("python", artist.document.text.replace("Population(3,", "Population(4,"))
    assert artist.document.brain.population[0].size == 4
    with golden.raises(ExperimentError):
        artist.document.write("python", artist.document.text.replace("0.1)", "0.10)"))


def test_a_drawn_brain_is_wired_and_runs_in_place_of_the_written_one(tmp_path: Path, golden: Golden) -> None:
    listings = [str(find_file("braitenberg_husky").parent / f"listing{one}.bibi") for one in (1, 2)]
    with cockpit(f"transfer_functions={listings}") as here, here.visit() as visitor:
        visitor.subscribe("/cockpit/designer", "/cockpit/experiment", "/cockpit/status")
        visitor.call("designer/turn", to="brain")
        shown = visitor.until(
            lambda: (visitor.last("designer") or {}).get("kind") == "brain" and visitor.last("designer")
        )
        assert [box["name"] for box in shown["boxes"]] == ["circuit"]
        assert not shown["is_drawn"], "brain.py of the experiment was written by a person"
        with pytest.raises(RefusedError, match=r"brain\.py"):
            visitor.call("designer/do", command="add", arguments={"path": "", "field": "population"})

        artist = Artist(tmp_path / "drawn.py")
        draw_the_brain_of_the_paper(artist)
        artist.document.save()
        visitor.call("designer/open", file=str(artist.document.path))
        found = visitor.call("designer/check")["findings"]
        assert [one for one in found if one["weight"] != "note"] == []
        visitor.call(
            "designer/do",
            command="set",
            arguments={"path": "population/2", "field": "name", "text": "wheels"},
        )
        with golden.raises(RefusedError):
            visitor.call("designer/run")
        visitor.call("designer/save")
        answer = visitor.call("designer/run")
        assert not answer["applied"], "the functions still ask for the actors"
        assert "actors" in answer["findings"][0]["summary"]
        assert here.session.run is here.run, "the run before goes on"
        visitor.call("designer/undo")
        visitor.call("designer/save")
        assert visitor.call("designer/run")["applied"]
        visitor.until(lambda: [one["label"] for one in visitor.last("experiment")["populations"]]
                      == ["sensors", "spontaneous", "actors"])  # fmt: skip
        visitor.until(lambda: visitor.last("status")["t_s"] > 0.2)
        visitor.call("pause")
        visitor.call("branch")
        assert here.session.beside is not None
        assert here.session.beside.functions.texts == here.session.functions.texts
        visitor.call("part")
        visitor.call("designer/open", file=str(find_file("braitenberg_husky").parent / "brain.py"))
        assert visitor.call("designer/run")["applied"], "and back to the brain of the experiment"
        assert list(here.session.run.brain.network.populations) == ["circuit"]
        assert here.session.run.experiment.brain.populations


def test_a_run_that_restarts_with_a_drawn_brain_shows_the_warnings_of_checks(tmp_path: Path) -> None:
    artist = Artist(tmp_path / "drawn.py")
    draw_the_brain_of_the_paper(artist)
    artist.document.save()
    functions = tmp_path / "twice.py"
    functions.write_text(DRIVES.format("drive") + DRIVES.format("drive_too"))
    with cockpit(f"transfer_functions=[{functions}]") as here, here.visit() as visitor:
        visitor.call("designer/turn", to="brain")
        visitor.call("designer/open", file=str(artist.document.path))
        assert visitor.call("designer/run")["applied"]
        assert here.session.run is not here.run
        told = [one.code for one in here.session.run.problems]
        assert told.count(Code.NRP229) == 1
