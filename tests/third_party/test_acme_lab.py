"""A distribution of somebody else goes through every door of the core, with public names only.

It is put on the path with the entry points of its ``pyproject.toml``. An experiment in it uses its parts on
real engines.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from command_fixtures import nrp

from nrp_core import Recording, Run, load_experiment, open_world, read_model, run
from nrp_core.brain import builder
from nrp_core.experiment import Result

__all__ = ["nrp"]

ROOT = Path(__file__).parents[2]
HERE = Path(__file__).parent
PACKAGE = HERE / "acme_lab"
PROJECT = tomllib.loads((HERE / "pyproject.toml").read_text())["project"]
GROUPS: dict[str, dict[str, str]] = PROJECT["entry-points"]


@pytest.fixture(autouse=True, scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Put the distribution on the path of this process and of its children."""
    site = tmp_path_factory.mktemp("site")
    info = site / "acme_lab-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme-lab\nVersion: 1.0\n")
    lines = [
        f"[{group}]\n" + "".join(f"{name} = {target}\n" for name, target in entries.items())
        for group, entries in GROUPS.items()
    ]
    (info / "entry_points.txt").write_text("".join(lines))
    with pytest.MonkeyPatch.context() as patch:
        for path in (site, HERE):
            patch.syspath_prepend(path)
        patch.setenv("PYTHONPATH", os.pathsep.join(map(str, (site, HERE))))
        yield


@pytest.fixture(scope="module")
def recorded(lab: None, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    """The recording and the result of half a second of the patrol."""
    folder = tmp_path_factory.mktemp("recorded") / "patrol"
    return folder, run("acme_patrol", ["duration=0.5 s"], record=folder)


def test_every_part_acts_in_a_run(recorded: tuple[Path, Result]) -> None:
    folder, result = recorded
    assert result.complete
    assert list(result.problems) == []
    recording = Recording(folder)
    nose = recording.frame("/cart/nose")
    thrust = recording.frame("/cart/thrust")
    assert nose["concentration"].iloc[1:].std() > 0.0  # it has noise, and the cart leaves the plume
    assert (nose["concentration"] > 1.0).any()
    assert nose["response"].iloc[-1] < nose["response"].iloc[0]  # the receptor has adapted
    assert thrust["data"].max() > 1.0  # of the device, by a rule, onto the drive
    assert result.final_pose["cart"]["x"] > 0.1
    momentum = recording.frame("/observables/momentum")["data"]
    assert momentum.max() > 0.01
    assert result.criteria["gathers_way"].passed


def test_the_run_is_the_same_on_the_other_engine() -> None:
    pytest.importorskip("pybullet")
    result = run("acme_patrol", ["world.backend=pybullet", "duration=0.2 s"])
    assert result.complete
    assert result.final_pose["cart"]["x"] > 0.01


def test_its_recording_is_replayed_exported_and_read_by_its_command(
    recorded: tuple[Path, Result], nrp: Any, tmp_path: Path
) -> None:
    folder, result = recorded
    assert nrp("replay", "--verify", folder).code == 0
    spikes = nrp("acme-spikes", folder)
    assert spikes.code == 0
    assert f"cells: {result.spikes['cells']}" in spikes.out.splitlines()
    assert "counts" in nrp("export", "--help").out
    done = nrp("export", folder, "--format", "counts", "-o", tmp_path / "patrol.counts")
    assert done.code == 0
    assert f"cells {result.spikes['cells']}" in (tmp_path / "patrol.counts").read_text().splitlines()


def test_its_room_and_its_service_are_those_of_the_world() -> None:
    with open_world("acme_patrol") as world:
        assert {model.name for model in world.scene.models} == {"wall", "cart"}
        assert world.call("/acme/weigh", "cart").mass == pytest.approx(2.1)


def test_the_hinge_follows_and_the_state_of_the_nose_is_saved_and_restored() -> None:
    with Run(load_experiment("acme_patrol")) as opened:
        nose: Any = opened.world.subscribe("/cart/nose")
        joints: Any = opened.world.subscribe("/cart/joint_states")
        opened.run(until_s=0.2)
        assert joints.latest.message.name == ["hinge"]
        assert joints.latest.message.position[0] > 0.05
        saved = opened.world.snapshot()
        opened.world.run_until(400_000_000)
        first = nose.latest.message
        opened.world.restore(saved)
        opened.world.run_until(400_000_000)
        assert nose.latest.message == first
        assert first.response != 0.0


def test_its_connector_and_its_synapse_make_a_network() -> None:
    from acme_lab.networks import Ring  # type: ignore[import-not-found]

    sim = builder()
    sim.setup(timestep=0.1)
    a, b = sim.Population(4, sim.SpikeSourcePoisson()), sim.Population(4, sim.IF_curr_exp())
    projection = sim.Projection(a, b, Ring(1), sim.AcmeDepression(weight=1.0))
    assert projection.get("tau_D", format="list") == [(i, (i + 1) % 4, 300.0) for i in (3, 0, 1, 2)]


def test_its_files_are_experiments_and_networks(nrp: Any, tmp_path: Path) -> None:
    short = tmp_path / "short.acme"
    short.write_text("0.06 s")
    (tmp_path / "ring.edges").write_text("0 1 0.5\n1 2 0.5\n2 0 0.5\n")
    settings = [f"brain.model={tmp_path / 'ring.edges'}", "brain.populations={all: '0:3'}"]
    result = run(short, settings)
    assert result.complete
    assert (result.duration_s, list(result.spikes)) == (pytest.approx(0.06), ["all", "cells"])
    done = nrp("import", short, "-o", tmp_path / "imported")
    assert done.code == 0, done.err
    assert load_experiment(tmp_path / "imported").duration == 60_000_000


def test_nothing_is_reported_about_its_files() -> None:
    assert read_model(PACKAGE / "patrol" / "cart.sdf").warnings == ()


def test_it_goes_through_every_door_of_the_core() -> None:
    sources = (ROOT / "nrp_core").rglob("*.py")
    pattern = re.compile(r'Registry(?:\[.*\])?\(\s*"(nrp_core\.\w+)"')
    doors = {group for path in sources for group in pattern.findall(path.read_text())}
    elsewhere = {  # of a whole simulator, or of a whole other platform: plugins of the repository use them
        "nrp_core.platforms", "nrp_core.pynn_dialects", "nrp_core.pynn_runners", "nrp_core.script_languages",
    }  # fmt: skip
    assert doors - elsewhere <= GROUPS.keys()
