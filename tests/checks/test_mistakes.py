"""Mistakes that once passed in silence, each on a copy of an experiment that ships."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

from nrp_core import load_experiment
from nrp_core.checks.validate import validate_file
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Finding, InvalidExperimentError

Broken = Callable[..., list[Finding]]


def _messages(found: list[Finding]) -> str:
    return "\n".join(map(str, found))


def test_a_file_without_transfer_functions_is_refused_before_the_run(husky: Path, broken: Broken) -> None:
    (husky / "nothing.py").write_text("x = 3\n")
    found = broken("experiment.yaml", "listing2.py]", "listing2.py, nothing.py]")
    assert "nothing.py:1: declares no transfer function" in _messages(found)


def test_cameras_are_not_scaled_to_nothing(husky: Path) -> None:
    found = _messages(validate_file(husky, ["world.options.image_scale=0.009"]))
    assert "world.options.image_scale: should be greater than or equal to 0.01, not 0.009" in found


def test_an_experiment_without_a_name_is_refused(broken: Broken) -> None:
    assert "name: " in _messages(broken("experiment.yaml", "name: braitenberg_husky", "name: ''"))


def test_an_extending_file_cannot_remove_a_missing_key(husky: Path) -> None:
    path = husky / "less.yaml"
    path.write_text("extends: experiment.yaml\nname: less\nevents: {left_rde: null}\n")
    found = _messages(validate_file(path))
    assert "less.yaml:3:10: there is no 'left_rde' to remove; did you mean 'left_red'?" in found


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("duration=", "'duration' cannot be removed: an experiment needs it"),
        ("criteria.reaches_lfet=null", "there is no 'reaches_lfet' to remove; did you mean 'reaches_left'"),
    ],
)
def test_an_override_that_removes_names_what_it_cannot_remove(
    husky: Path, override: str, message: str
) -> None:
    found = _messages(validate_file(husky, [override]))
    assert f"in the override '{override}': {message}" in found


def test_an_extending_file_and_an_override_still_remove_what_is_there(husky: Path) -> None:
    path = husky / "less.yaml"
    path.write_text("extends: experiment.yaml\nname: less\nevents: {all_blue: null}\ncriteria: null\n")
    experiment = load_experiment(path, ["events.right_red=null"])
    assert list(experiment.events) == ["left_red"]
    assert not experiment.criteria


def test_two_parts_with_one_topic_are_a_matter_of_topics(broken: Broken) -> None:
    found = broken("husky.sdf", "<topic>camera</topic>", "<topic>odom</topic>")
    assert [finding.code.name for finding in found] == ["NRP212"]


def test_a_negative_deviation_is_refused_where_it_stands(broken: Broken, golden: Golden) -> None:
    noise = "<noise><type>gaussian</type><stddev>-0.1</stddev></noise></camera>"
    (finding,) = broken("husky.sdf", "</camera>", noise)
    assert finding.path is not None
    assert finding.path.name == "husky.sdf"
    assert "-0.1" in finding.message
    golden(finding.message)


@pytest.mark.parametrize("t_s", [-1.0, float("nan"), float("inf"), "2 s", 2 * 10**9])
def test_a_run_refuses_an_impossible_time(husky: Path, t_s: Any, golden: Golden) -> None:
    with Run(load_experiment(husky)) as run, golden.raises(Exception) as raised:
        run.run(t_s)
    assert type(raised.value).__name__ == "TimestepError"


def test_an_error_of_a_removal_is_an_error_of_the_experiment(husky: Path, golden: Golden) -> None:
    with golden.raises(InvalidExperimentError):
        load_experiment(husky, ["name=null"])


_BRAIN = """
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
circuit = sim.Population(8, sim.IF_cond_alpha(), label="circuit")
late = sim.Population(1, sim.SpikeSourceArray(spike_times=[{first}]), label="late")
noise = sim.Population(1, sim.SpikeSourcePoisson(rate=10.0, start={start}), label="noise")
sim.Projection(late, circuit, sim.{connector}, sim.StaticSynapse(weight={weight}, delay={delay}), label="a")
sim.Projection(noise, circuit, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.1), label="b")
"""
_SOUND = {
    "weight": "0.1",
    "first": "10.0",
    "start": "0.0",
    "connector": "AllToAllConnector()",
    "delay": "1.0",
}


@pytest.mark.parametrize("source", ["SpikeSourceGamma(beta=50.0)", "SpikeSourcePoissonRefractory(rate=50.0)"])
def test_sources_of_other_intervals_are_checked_as_others(source: str, husky: Path) -> None:
    text = _BRAIN.format(**_SOUND).replace("SpikeSourcePoisson(rate=10.0, start=0.0)", source)
    assert source in text
    (husky / "brain.py").write_text(text)
    assert not [one for one in validate_file(husky) if one.code.name in ("NRP204", "NRP208", "NRP248")]


def test_a_brain_script_does_not_get_the_arguments_of_the_command(husky: Path) -> None:
    (husky / "brain.py").write_text("import sys\n" + _BRAIN.format(**_SOUND) + "assert len(sys.argv) == 1\n")
    assert not [finding for finding in validate_file(husky) if finding.code.name == "NRP208"]


def test_a_source_without_a_weight_is_reported(broken: Broken) -> None:
    found = broken("nrp_gains.py", "nrp.poisson)", "nrp.poisson, weight=0.0)", experiment="nrp_gains.yaml")
    assert "the weight of the source 'red_left_eye' is 0" in _messages(found)
