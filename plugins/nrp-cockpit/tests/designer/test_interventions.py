"""Interventions are put into brains of people and drawn ones, and run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from brains import Artist, draw_the_brain_of_the_paper
from golden import Golden
from nrp_cockpit.designer.brain.document import BrainDocument
from nrp_cockpit.designer.brain.interventions import interventions_of, overrides_of, yaml_of
from visitors import SMALL, RefusedError, Visitor, cockpit

from nrp_core.checks.validate import validate
from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment

GIVEN = """\
brain:
  interventions:
    - {silence: circuit}
    - {lesion: '6'}
    - {scale: {sources: sensors, by: 0.5}, at: 1.5 ms}
    - {scale: {sources: sensors, targets: actors, by: 2}}
    - {activate: {cells: actors, rate: 100 Hz, weight: -0.00015, duration: 200 ms}, at: 300 ms}
"""


def _husky(*overrides: str) -> Experiment:
    return load_experiment("braitenberg_husky", [SMALL, *overrides])


def test_interventions_of_every_kind_are_read_and_written_alike(tmp_path: Path) -> None:
    file = tmp_path / "given.yaml"
    file.write_text(f"name: given\nextends: braitenberg_husky\n{GIVEN}")
    sections = load_experiment(file).brain.interventions
    drawn = interventions_of(sections)
    assert yaml_of(drawn) == GIVEN
    assert _husky(*overrides_of(drawn)).brain.interventions == sections
    file.write_text(f"name: given\nextends: braitenberg_husky\n{yaml_of(())}")
    assert load_experiment(file).brain.interventions == _husky(*overrides_of(())).brain.interventions == ()


def _do(visitor: Visitor, command: str, **arguments: Any) -> str:
    return str(visitor.call("designer/do", command=command, arguments=arguments)["selected"])


def _turning_rad_s(visitor: Visitor, here: Any) -> float:
    """Return how fast the robot turns when 0.5 s of the run have passed."""
    visitor.until(lambda: here.session.now_ns > 500_000_000)
    visitor.call("pause")
    return abs(float(here.session.run.world.model_motion("husky").angular[2]))


def test_a_brain_of_a_person_runs_with_interventions_and_without_them_again() -> None:
    with cockpit() as here, here.visit() as visitor:
        visitor.subscribe("/cockpit/designer")
        script = here.run.experiment.brain.model.read_text()
        visitor.call("play")
        assert _turning_rad_s(visitor, here) > 0.1
        visitor.call("designer/turn", to="brain")
        made = _do(visitor, "add", path="", field="intervention")
        state = visitor.until(lambda: visitor.last("designer")["revision"] > 1 and visitor.last("designer"))
        assert made == "intervention/0"
        assert not state["is_drawn"]
        assert state["is_saved"]
        assert set(state["cells"]) == {"circuit", "sensors", "actors"}
        assert state["interventions"] == "brain:\n  interventions:\n    - {silence: circuit}\n"
        assert [one for one in visitor.call("designer/check")["findings"] if one["weight"] != "note"] == []

        _do(visitor, "set", path=f"{made}/effect", field="cells", text="circit")
        (wrong,) = [one for one in validate(_husky("brain.interventions=[{silence: circit}]"))
                    if one.code.name == "NRP202"]  # fmt: skip
        answer = visitor.call("designer/run")
        for found in (visitor.call("designer/check")["findings"], answer["findings"]):
            (error,) = [one for one in found if one["weight"] == "error"]
            assert error["path"] == made
            assert wrong.text.endswith(f": {error['summary']}")
            assert error["summary"].startswith("the brain has no population 'circit'")
        assert not answer["applied"]
        assert here.session.run is here.run, "the run before goes on"

        visitor.call("designer/undo")
        assert visitor.call("designer/run")["applied"]
        assert here.session.run is not here.run
        assert (
            here.session.run.experiment.brain.interventions
            == _husky("brain.interventions=[{silence: circuit}]").brain.interventions
        )
        assert _turning_rad_s(visitor, here) < 1e-3, "no spike reaches the cells that turn it"
        _do(visitor, "remove", path=made)
        assert visitor.call("designer/run")["applied"]
        assert here.session.run.experiment.brain.interventions == ()
        assert _turning_rad_s(visitor, here) > 0.1
        assert here.run.experiment.brain.model.read_text() == script


def test_the_reason_of_a_refused_intervention_is_shown_beside_it() -> None:
    with cockpit("brain.interventions=[{lesion: actors, at: 1 s}]") as here, here.visit() as visitor:
        visitor.subscribe("/cockpit/designer")
        visitor.call("designer/turn", to="brain")
        state = visitor.until(lambda: visitor.last("designer"))
        assert state["interventions"].splitlines()[2:] == ["    - {lesion: actors, at: 1000 ms}"]
        made = _do(visitor, "add", path="", field="intervention")
        _do(visitor, "become", path=f"{made}/effect", type="Scale")
        _do(visitor, "set", path=f"{made}/effect", field="by", text="-1")
        (error,) = visitor.call("designer/check")["findings"]
        assert error["path"] == made == "intervention/1"
        assert (
            error["summary"] == "brain.interventions.1.scale.by: should be greater than or equal to 0, not -1"
        )
        _do(visitor, "set", path=f"{made}/effect", field="by", text="0.5")
        assert [one for one in visitor.call("designer/check")["findings"] if one["weight"] == "error"] == []
        with pytest.raises(RefusedError, match=r"'by'.*'half'"):
            _do(visitor, "set", path=f"{made}/effect", field="by", text="half")
        with pytest.raises(RefusedError, match=r"brain\.py"):
            _do(visitor, "set", path="", field="timestep", text="1")
        assert _do(visitor, "copy", path=made) == "intervention/2"
        assert _do(visitor, "move", path=made, to=0) == "intervention/0"


def test_interventions_are_no_part_of_a_drawn_script_and_follow_new_names(
    tmp_path: Path, golden: Golden
) -> None:
    artist = Artist(tmp_path / "drawn.py")
    with golden.raises(ExperimentError):
        artist.do("add", path="", field="intervention")
    cells = artist.population("cells", 3)
    artist.projection(cells, cells, 0.1)
    artist.document.save()
    before = artist.document.text
    made = artist.do("add", path="", field="intervention")
    artist.do("become", path=f"{made}/effect", type="Scale")
    assert artist.document.text == before
    assert artist.document.is_saved
    artist.set(cells, name="first")
    (one,) = artist.document.brain.intervention
    assert one.effect.targets == "first"  # type: ignore[attr-defined]
    assert artist.document.brain.projection[0].source == "first"
    artist.document.write("python", artist.document.text.replace("Population(3,", "Population(4,"))
    assert artist.document.brain.intervention == (one,)
    artist.document.save()
    assert BrainDocument(artist.document.path, None, (one,)).brain == artist.document.brain


def test_a_drawn_brain_runs_with_interventions_that_name_its_populations(tmp_path: Path) -> None:
    artist = Artist(tmp_path / "drawn.py")
    draw_the_brain_of_the_paper(artist)
    artist.document.save()
    with cockpit() as here, here.visit() as visitor:
        visitor.subscribe("/cockpit/designer")
        visitor.call("designer/open", file=str(artist.document.path))
        assert visitor.call("designer/run")["applied"]
        made = _do(visitor, "add", path="", field="intervention")
        _do(visitor, "set", path=f"{made}/effect", field="cells", text="circuit")
        (error,) = [one for one in visitor.call("designer/check")["findings"] if one["weight"] == "error"]
        assert error["path"] == made
        assert error["summary"].startswith("the brain has no population 'circuit'")
        _do(visitor, "set", path=f"{made}/effect", field="cells", text="spontaneous")
        assert [one for one in visitor.call("designer/check")["findings"] if one["weight"] == "error"] == []
        assert visitor.call("designer/run")["applied"]
        network = here.session.run.brain.network
        assert list(network.populations) == ["sensors", "spontaneous", "actors"]
        sizes = {one.pre: one.size for one in network.projections}
        assert sizes["spontaneous"] == 0
        assert sizes["sensors"] > 0
        visitor.call("pause")
