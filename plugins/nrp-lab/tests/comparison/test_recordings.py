"""Bugs put into copies of backends are found and named; the copies without them agree."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from nrp_lab.comparison.divergence import Divergence, divergence_of
from nrp_lab.comparison.grid import GridCell, RunGrid, run_grid
from nrp_lab.comparison.judgement import Answer, Factor, JudgedPart, Relation
from nrp_lab.comparison.metric import Margins, all_metrics
from nrp_lab.comparison.result import GridDiff, PairDiff

from nrp_core.experiment.model.section import Range

pytestmark = [pytest.mark.slow, pytest.mark.heavy]

COPIES = '''
from dataclasses import replace

from nrp_brain_event import EventBackend
from nrp_world_mujoco import MujocoBackend
from nrp_world_mujoco.engine import MujocoEngine


class Same(EventBackend):
    """A copy without a bug."""


class LateSynapses(EventBackend):
    """Every delay is a time step (0.1 ms) too long."""

    def open(self, network, *, seed, options):
        late = [replace(one, delay_ms=one.delay_ms + 0.1) for one in network.projections]
        return super().open(replace(network, projections=tuple(late)), seed=seed, options=options)


class FlippedSynapses(EventBackend):
    """What inhibits excites."""

    def open(self, network, *, seed, options):
        flipped = [replace(one, receptor="excitatory") for one in network.projections]
        return super().open(replace(network, projections=tuple(flipped)), seed=seed, options=options)


class Mirrored(MujocoBackend):
    """What its cameras see on the right is on the left."""

    def engine(self, scene, *, seed, options):
        class Wrong(MujocoEngine):
            def _do_render(self, model, link, camera):
                return super()._do_render(model, link, camera)[:, ::-1].copy()

        return Wrong(scene, seed=seed, capabilities=self.capabilities(options), options=options)


class LargeWheels(MujocoBackend):
    """Its wheels are 2 % larger than its drives believe."""

    def engine(self, scene, *, seed, options):
        class Wrong(MujocoEngine):
            def _do_set_drive(self, model, drive, velocity):
                faster = replace(velocity, forward=1.02 * velocity.forward, turn=1.02 * velocity.turn)
                super()._do_set_drive(model, drive, faster)

        return Wrong(scene, seed=seed, capabilities=self.capabilities(options), options=options)
'''
ENTRIES = """
[nrp_core.brain]
same = copies_with_bugs:Same
late = copies_with_bugs:LateSynapses
flipped = copies_with_bugs:FlippedSynapses
[nrp_core.world]
large_wheels = copies_with_bugs:LargeWheels
mirrored = copies_with_bugs:Mirrored
"""
SETTINGS = ("world.options.image_scale=0.1", "events.left_red.at=0.5 s", "duration=2 s",
            "observables={moved: {displacement: husky}}")  # fmt: skip
SEEDS = 4
BRAINS, WORLDS = ("event", "same", "late", "flipped"), ("mujoco", "large_wheels")


@pytest.fixture(scope="module")
def copies(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Install the copies of backends."""
    folder = tmp_path_factory.mktemp("copies")
    info = folder / "copies-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: copies\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(ENTRIES)
    (folder / "copies_with_bugs.py").write_text(COPIES)
    sys.path.insert(0, str(folder))
    yield
    sys.path.remove(str(folder))


@pytest.fixture(scope="module")
def diff(copies: None, tmp_path_factory: pytest.TempPathFactory) -> GridDiff:
    folder = tmp_path_factory.mktemp("results")
    grid = RunGrid.of("braitenberg_husky", BRAINS, WORLDS, SEEDS, SETTINGS)
    runs = run_grid(grid, folder, 1, lambda done, total, last: None)
    return GridDiff.of(grid, runs, all_metrics(), Margins(), folder)


def test_an_observable_is_compared_in_its_own_unit(diff: GridDiff) -> None:
    (judged,) = [one for one in diff.judgements if one.metric.name == "observables"]
    assert (judged.metric.title, judged.metric.unit) == ("Observable moved", "m")
    assert [part.name for part in judged.parts] == ["moved.min", "moved.max", "moved.mean", "moved.last"]
    cells = {(one.brain, one.world): one.values for one in judged.parts[1].cells}
    assert len(cells["event", "mujoco"]) == SEEDS
    assert cells["event", "mujoco"] == cells["same", "mujoco"] != cells["event", "large_wheels"]
    assert all(0.1 < value < 5.0 for value in cells["event", "mujoco"])


def part_of(diff: GridDiff, metric: str, part: str) -> JudgedPart:
    (judged,) = [one for one in diff.judgements if one.metric.name == metric]
    (found,) = [one for one in judged.parts if one.name == part]
    return found


def relations(part: JudgedPart, factor: Factor) -> dict[tuple[str, str], Relation]:
    return {(one.one, one.other): one.relation(part.margin) for one in part.contrasts if one.factor is factor}


def divergence(diff: GridDiff, one: tuple[str, str], other: tuple[str, str]) -> Divergence:
    seed = diff.grid.seeds[0]
    return divergence_of(diff.runs[GridCell(*one, seed)], diff.runs[GridCell(*other, seed)])


@pytest.mark.heavy
def test_a_wheel_that_is_two_percent_larger_is_named_with_its_size(diff: GridDiff) -> None:
    for way in ("forward", "turn"):
        part = part_of(diff, "drive_response", f"husky/{way}")
        assert part.answer is Answer.WORLD
        (one,) = [one for one in part.contrasts if one.factor is Factor.WORLD]
        assert one.estimate.mean == pytest.approx(0.02, abs=0.002)


def test_a_larger_wheel_parts_runs_in_the_world_while_brain_and_commands_are_the_same(diff: GridDiff) -> None:
    first = divergence(diff, ("event", "mujoco"), ("event", "large_wheels")).first
    assert first is not None
    assert (first.group, first.signal) == ("world", "/gazebo/model_states")
    assert first.step == 1  # with the first command


def test_a_mirrored_camera_is_named_and_not_the_device_that_it_drives(copies: None, tmp_path: Path) -> None:
    settings = ("world.options.image_scale=0.1", "duration=0.1 s")
    grid = RunGrid.of("braitenberg_husky", ("event",), ("mujoco", "mirrored"), 1, settings)
    runs = run_grid(grid, tmp_path, 1, lambda done, total, last: None)
    first = divergence_of(*runs.values()).first
    assert first is not None
    assert (first.group, first.signal) == ("inputs", "/husky/camera/hash")


def test_a_setting_that_somebody_sets_is_not_drawn_anew() -> None:
    grid = RunGrid.of("braitenberg_husky", (), (), 1, ("events.left_red.at=0.5 s",))
    assert grid.varied == {}
    assert list(RunGrid.of("braitenberg_husky", (), (), 1).varied) == ["events.left_red.at"]


def test_a_delay_of_one_step_more_is_named_by_the_spike_that_is_late(diff: GridDiff) -> None:
    first = divergence(diff, ("event", "mujoco"), ("late", "mujoco")).first
    assert first is not None
    assert (first.group, first.signal) == ("brain", "/brain/circuit/spikes")
    told = [
        re.match(r"neuron (\d+) at ([\d.]+) ms", words).groups()  # type: ignore[union-attr]
        for words in (first.recorded, first.now)
    ]
    assert told[0][0] == told[1][0]
    assert float(told[1][1]) - float(told[0][1]) == pytest.approx(0.1, abs=0.05)


def test_a_synapse_of_the_wrong_sign_is_named_by_the_neurons_it_acts_on(diff: GridDiff) -> None:
    found = relations(part_of(diff, "rate", "circuit[5]"), Factor.BRAIN)
    assert found["event", "flipped"] is found["late", "flipped"] is Relation.DIFFERENT
    assert found["event", "same"] is found["event", "late"] is Relation.EQUIVALENT
    first = divergence(diff, ("event", "mujoco"), ("flipped", "mujoco")).first
    assert first is not None
    assert (first.group, first.signal) == ("brain", "/brain/circuit/spikes")


def test_a_copy_without_a_bug_is_the_same_to_the_last_bit(diff: GridDiff) -> None:
    found = divergence(diff, ("event", "mujoco"), ("same", "mujoco"))
    assert found.first is None
    assert found.steps == 101
    same = relations(part_of(diff, "spike_trains", "circuit"), Factor.BRAIN)["event", "same"]
    assert same is not Relation.DIFFERENT


def test_two_recordings_are_laid_side_by_side(diff: GridDiff) -> None:
    seed = diff.grid.seeds[0]
    folders = [diff.grid.folder(diff.folder, GridCell("event", world, seed)) for world in WORLDS]
    pair = PairDiff.of(*folders, all_metrics())
    assert not pair.is_identical
    response = next(row for row in pair.measured if row.metric.name == "drive_response")
    assert response.apart == pytest.approx(0.02, abs=0.002)
    worst = max(pair.deviations, key=lambda one: one.rms)
    assert worst.largest > 0
    again = PairDiff.of(folders[0], folders[0], all_metrics())
    assert again.is_identical
    assert all(not row.apart for row in again.measured)


@pytest.mark.heavy
def test_the_braitenberg_finding_is_the_same_on_all_simulators_within_a_few_seeds(tmp_path: Path) -> None:
    varied = {"events.left_red.at": Range(1, 7, "s")}
    settings = ("world.options.image_scale=0.1", "duration=16 s")
    grid = RunGrid.of(
        "braitenberg_husky", ("event", "spinnaker"), ("mujoco", "pybullet"), 7, settings, varied
    )
    runs = run_grid(grid, tmp_path, 2, lambda done, total, last: None)
    diff = GridDiff.of(grid, runs, all_metrics(), Margins(), tmp_path)
    assert diff.failures == {}
    criteria, times = diff.finding
    assert criteria.answer is Answer.AGREES
    assert times.metric.name == "time_to_event"
    assert not times.answer.is_dependent
    left = relations(part_of(diff, "time_to_event", "reaches_left"), Factor.WORLD)
    assert left["mujoco", "pybullet"] is Relation.EQUIVALENT
    # what differs is listed: on a grid of 1 ms a neuron fires later, and so less often
    assert part_of(diff, "rate", "circuit[7]").answer is Answer.BRAIN


def test_the_first_divergence_is_more_than_rounding(tmp_path: Path) -> None:
    settings = ("world.options.image_scale=0.1", "duration=0.2 s")
    grid = RunGrid.of("braitenberg_husky", ("event",), ("mujoco", "pybullet"), 1, settings)
    found = divergence_of(*run_grid(grid, tmp_path, 1, lambda done, total, last: None).values())
    assert not found.is_identical
    assert found.first is not None
    assert found.first.step > 0  # at the start the poses differ by 1e-16
    for words in (found.first.recorded, found.first.now):
        assert "e-17" not in words
