"""Engines with a bug are named in the first line of a comparison; engines without one agree."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
import wrong_engines
from nrp_lab.comparison.engine_verdict import Agreement, EngineVerdict, compare_engines
from nrp_lab.comparison.grid import RunGrid
from nrp_lab.comparison.metric import Margins

FOLDER = Path(wrong_engines.__file__).parent
YARD = str(FOLDER / "yard" / "experiment.yaml")
HUSKY = "braitenberg_husky"
SHORT = ("comparison=null", "duration=4 s", "events.left_red.at=0.5 s", "world.options.image_scale=0.1")
SETTINGS = {HUSKY: SHORT, YARD: ()}

WRONG_WORLDS = {
    "LateCommands": (HUSKY, "delay of motion"),
    "LargeWheels": (HUSKY, "motion"),
    "ReversedGear": (HUSKY, "motion"),
    "BlueFirst": (HUSKY, "images"),
    "LightGravity": (YARD, "sensor values"),
    "HeavyLinks": (YARD, "stand/weight.wrench.force"),
    "SlipperyGround": (YARD, "sled/velocity"),
    "NoisyScanner": (YARD, "noise of sensors"),
    "LateInertialSensor": (YARD, "delay of sensors"),
    "TurnedInertialSensor": (YARD, "cart/imu"),
}
WRONG_BRAINS = {
    "StrongSynapses": (HUSKY, "rate|output"),
    "FlippedSynapses": (HUSKY, "firing rate"),
    "HighThreshold": (YARD, "firing rate"),
    "LongRefractoryTime": (YARD, "firing rate"),
    "SlowMembrane": (YARD, "firing rate"),
    "LostSpikes": (YARD, "firing rate"),
}


@pytest.fixture(scope="module", autouse=True)
def _installed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Install the engines of this test as a distribution with entry points."""
    folder = tmp_path_factory.mktemp("wrong_engines")
    info = folder / "wrong_engines-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: wrong-engines\nVersion: 1.0\n")
    worlds = "".join(f"{name} = wrong_engines:{name}\n" for name in ("SameWorld", *WRONG_WORLDS))
    brains = "".join(f"{name} = wrong_engines:{name}\n" for name in ("SameBrain", *WRONG_BRAINS))
    (info / "entry_points.txt").write_text(f"[nrp_core.world]\n{worlds}[nrp_core.brain]\n{brains}")
    sys.path.insert(0, str(folder))
    yield
    sys.path.remove(str(folder))


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A folder for the runs of each experiment: those of the right engines are made once."""
    return {experiment: tmp_path_factory.mktemp("runs") for experiment in SETTINGS}


def verdict(
    experiment: str, folders: dict[str, Path], brains: str = "event", worlds: str = "mujoco"
) -> EngineVerdict:
    folder = folders[experiment]
    grid = RunGrid.of(experiment, brains.split(","), worlds.split(","), 1, SETTINGS[experiment])
    return compare_engines(grid, folder, Margins(), lambda done, total, last: None)


ALIKE = {"ReversedGear", "FlippedSynapses", "LongRefractoryTime", "SlowMembrane"}
"""Named as another one of their side is."""


def by_hand_if_alike(names: Iterable[str]) -> list[Any]:
    return [pytest.param(name, marks=pytest.mark.heavy if name in ALIKE else ()) for name in names]


@pytest.mark.one_of(8)
@pytest.mark.parametrize("name", by_hand_if_alike(WRONG_WORLDS))
def test_a_wrong_world_is_named_in_the_headline(name: str, folders: dict[str, Path]) -> None:
    experiment, named = WRONG_WORLDS[name]
    found = verdict(experiment, folders, worlds=f"mujoco,{name}")
    assert found.agreement is Agreement.DIFFER
    assert re.search(named, found.headline), found.headline
    assert f"world mujoco -> {name}" in found.headline


@pytest.mark.one_of(6)
@pytest.mark.parametrize("name", by_hand_if_alike(WRONG_BRAINS))
def test_a_wrong_brain_is_named_in_the_headline(name: str, folders: dict[str, Path]) -> None:
    experiment, named = WRONG_BRAINS[name]
    found = verdict(experiment, folders, brains=f"event,{name}")
    assert found.agreement is Agreement.DIFFER
    assert re.search(named, found.headline), found.headline
    assert f"brain event -> {name}" in found.headline


OTHERS, COPIES = ("event", "mujoco,pybullet"), ("event,SameBrain", "mujoco,SameWorld")


@pytest.mark.one_of(3)
@pytest.mark.parametrize(
    ("experiment", "brains", "worlds"),
    [
        pytest.param(HUSKY, *OTHERS, id="husky, others"),
        pytest.param(YARD, *COPIES, id="yard, copies"),
        pytest.param(YARD, *OTHERS, id="yard, others", marks=pytest.mark.heavy),
        pytest.param(HUSKY, *COPIES, id="husky, copies", marks=pytest.mark.heavy),
    ],
)
def test_engines_without_a_bug_agree(
    experiment: str, brains: str, worlds: str, folders: dict[str, Path]
) -> None:
    found = verdict(experiment, folders, brains, worlds)
    assert found.agreement is Agreement.AGREE, found.headline


def test_the_two_brains_agree_where_a_millisecond_more_or_less_does_not_matter(
    folders: dict[str, Path],
) -> None:
    found = verdict(YARD, folders, "event,spinnaker")
    assert found.agreement is Agreement.AGREE, found.headline
