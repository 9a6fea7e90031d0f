"""A copy of an experiment is, bit for bit, the run alone with its seed."""

import gc
import tracemalloc
from contextlib import ExitStack

import numpy as np
import pytest
from nrp_lab.side_by_side import SideBySide

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.errors import SimulationError
from nrp_core.experiment import Run, load_experiment

STEPS = 40
SEEDS = (3, 4, 11)
SMALL = "world.options.image_scale=0.1"


def opened(name, overrides):
    first = Run(load_experiment(name, overrides))
    return [first, *(Run(first.experiment, beside=first) for _ in SEEDS[1:])]


def recorder(run, seed):
    run.loop.reset(seed=seed)
    return run.brain.add_sink(SpikeRecorder(), np.arange(run.brain.network.size), name="all")


def path(run):
    return [run.world.model_motion(robot) for robot in run.experiment.world.robots]


def alone(name, overrides, seed):
    """Return the spikes and paths of a run, and its state at the end."""
    with Run(load_experiment(name, overrides)) as run:
        port = recorder(run, seed)
        paths = []
        for _ in range(STEPS):
            run.step()
            paths.append(path(run))
        return port.spikes(), paths, run.snapshot()


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("braitenberg_husky", [SMALL]),
        ("braitenberg_husky", [SMALL, "world.backend=pybullet"]),
        ("braitenberg_husky", [SMALL, "brain.options.resolution=0.1 ms"]),
        ("slalom_pioneer/trained", []),
        ("slalom_pioneer", ["brain.options.resolution=1 ms"]),
        ("following_head", [SMALL]),
    ],
)
@pytest.mark.parametrize("threads", [1, 2])
def test_a_copy_equals_its_run_alone(name, overrides, threads):
    if threads > 1 and "world.backend=pybullet" in overrides:
        pytest.skip("its copies step on one thread")
    if "world.backend=pybullet" in overrides:
        pytest.importorskip("pybullet")
    runs = opened(name, overrides)
    ports = [recorder(run, seed) for run, seed in zip(runs, SEEDS, strict=True)]
    paths = [[] for _ in runs]
    with SideBySide(threads) as together:
        for _ in range(STEPS):
            assert together.step([run.loop for run in runs]) == {}
            for run, passed in zip(runs, paths, strict=True):
                passed.append(path(run))
    for run, port, passed, seed in zip(runs, ports, paths, SEEDS, strict=True):
        spikes, path_alone, state = alone(name, overrides, seed)
        assert len(spikes) > 10
        assert np.array_equal(port.spikes().neurons, spikes.neurons)
        assert np.array_equal(port.spikes().times_ms, spikes.times_ms)
        assert passed == path_alone
        assert run.snapshot() == state
    for run in runs[::-1]:
        run.close()


OF_HUSKY = """
events.left_red.at=100 ms
events.left_red.publish={topic: /screens/left/color, value: red}
events.right_red.when.near={visual: null, point: [-0.02, 0], within: 5 cm}
events.all_blue.when={near: null, event: left_red, after: 300 ms}
criteria.turns_on_the_spot.stays_within.during.until=left_red
criteria.reaches_left.within_of.time=200 ms
criteria.moves={near: {model: husky, point: [-0.02, 0], within: 5 cm}}
criteria.stays={stays_within: {model: husky, distance: 2 cm}}
criteria.is_near={observable: {distance: [husky, right_vr_screen]}, above: 1 m, during: {until: all_blue}}
observables.way={displacement: husky}
"""
OF_SLALOM = """
criteria.touches_nothing={topic_stays: {name: /pioneer/clearance, above: 1.9, during: {since: 100 ms}}}
criteria.later={topic_stays: {name: /pioneer/clearance, below: 1.7, during: {since: 300 ms, until: 400 ms}}}
criteria.goes_on={stays_within: {model: pioneer, distance: 20 cm, during: {since: 60 ms}}}
"""


@pytest.mark.parametrize(("name", "lines"), [("braitenberg_husky", OF_HUSKY), ("slalom_pioneer", OF_SLALOM)])
def test_events_and_criteria_of_copies_happen_as_in_their_runs_alone(name, lines):
    overrides = [SMALL, *lines.split("\n")[1:-1]] if name == "braitenberg_husky" else lines.split("\n")[1:-1]
    runs = opened(name, overrides)
    for run, seed in zip(runs, SEEDS, strict=True):
        run.loop.reset(seed=seed)
    passed: list[list[object]] = [[] for _ in runs]
    with SideBySide() as together:
        for step in range(STEPS):
            assert together.step([run.loop for run in runs]) == {}
            for run, seen in zip(runs, passed, strict=True):
                seen.append(
                    (run.passed(), run.events, run.observables, run.outcomes() if step % 7 == 0 else None)
                )
    for number, seed in enumerate(SEEDS):
        with Run(load_experiment(name, overrides)) as run:
            run.loop.reset(seed=seed)
            for step in range(STEPS):
                run.step()
                outcomes = run.outcomes() if step % 7 == 0 else None
                assert passed[number][step] == (run.passed(), run.events, run.observables, outcomes)
            assert runs[number].snapshot() == run.snapshot()
            assert {*run.passed().values()} >= {True, False}
    for run in runs[::-1]:
        run.close()


@pytest.mark.heavy
@pytest.mark.parametrize("threads", [1, 2])
def test_each_of_a_thousand_copies_equals_its_run_alone(threads):
    n, steps = 1024, 25
    with ExitStack() as opened_runs, SideBySide(threads) as together:
        alone_run = opened_runs.enter_context(Run(load_experiment("slalom_pioneer")))
        runs = [opened_runs.enter_context(Run(alone_run.experiment, beside=alone_run)) for _ in range(n)]
        for seed, run in enumerate(runs):
            run.loop.reset(seed=seed)
        for _ in range(steps):
            assert together.step([run.loop for run in runs]) == {}
        for seed, run in enumerate(runs):
            alone_run.loop.reset(seed=seed)
            for _ in range(steps):
                alone_run.step()
            assert run.snapshot() == alone_run.snapshot()


def test_a_copy_allocates_few_objects_of_its_own():
    few, many = 5, 20
    with ExitStack() as opened_runs:
        first = opened_runs.enter_context(Run(load_experiment("slalom_pioneer")))

        def more(n):
            for _ in range(n):
                opened_runs.enter_context(Run(first.experiment, beside=first)).step()

        more(few)  # what copies share
        gc.collect()
        tracemalloc.start()
        try:
            more(many)
            gc.collect()
            allocated, _ = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert allocated / many < 160_000


def test_the_end_of_some_copies_unfreezes_no_objects_of_others():
    gc.unfreeze()
    runs = opened("slalom_pioneer", [])
    loops = [run.loop for run in runs]
    with SideBySide() as first, SideBySide() as second:
        first.step(loops)
        second.step(loops)
        first.close()
        assert gc.get_freeze_count() > 0
    assert gc.get_freeze_count() == 0
    gc.freeze()
    try:
        with SideBySide() as own:
            own.step(loops)
        assert gc.get_freeze_count() > 0
    finally:
        gc.unfreeze()
    for run in runs[::-1]:
        run.close()


FUNCTIONS = """
import hbp_nrp_client.tf_framework as nrp
from geometry_msgs.msg import Twist, Vector3

WHEEL = nrp.brain.actors[1]

@nrp.MapSpikeSink("wheel", WHEEL, nrp.population_rate)
@nrp.MapSpikeSource("eye", nrp.brain.sensors[3:5], nrp.poisson)
@nrp.Robot2Neuron()
def branches(t, wheel, eye):
    if wheel.rate > 20.0:
        eye.rate = wheel.rate
    else:
        eye.rate = 200.0

@nrp.MapSpikeSink("wheel", WHEEL, nrp.population_rate)
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", Twist))
def moves(t, wheel):
    return Twist(Vector3(1.0 / (wheel.rate - LIMIT) if t > 0.1 else wheel.rate), Vector3())
"""


def with_functions(tmp_path, limit):
    file = tmp_path / "functions.py"
    file.write_text(FUNCTIONS.replace("LIMIT", repr(limit)))
    return [f"transfer_functions=[{file}]", "criteria=null", "events=null"]


def test_an_error_of_one_copy_is_that_of_its_run_alone(tmp_path):
    with Run(load_experiment("braitenberg_husky", with_functions(tmp_path, -1.0))) as run:
        run.loop.reset(seed=SEEDS[1])
        for _ in range(10):
            run.step()
        limit = run.loop.functions[0].wheel.rate  # where the second copy divides by 0
    overrides = with_functions(tmp_path, limit)
    with pytest.raises(SimulationError) as expected:
        alone("braitenberg_husky", overrides, SEEDS[1])
    runs = opened("braitenberg_husky", overrides)
    for run, seed in zip(runs, SEEDS, strict=True):
        run.loop.reset(seed=seed)
    failed = {}
    with SideBySide() as together:
        for _ in range(STEPS):
            going = [number for number in range(len(runs)) if number not in failed]
            errors = together.step([runs[number].loop for number in going])
            failed |= {going[place]: error for place, error in errors.items()}
    assert {number: str(error) for number, error in failed.items()} == {1: str(expected.value)}
    assert "ZeroDivisionError" in str(failed[1])
    for run in runs[::-1]:
        run.close()


@pytest.mark.parametrize("name", ["braitenberg_husky", "slalom_pioneer"])
def test_copies_at_different_times_equal_their_runs_alone(name):
    runs = opened(name, [SMALL] if "husky" in name else [])
    with SideBySide() as together:
        for seed, run in zip(SEEDS, runs, strict=True):
            run.loop.reset(seed=seed)
        for step in range(STEPS + 10):
            if step == 10:
                runs[1].loop.reset(seed=SEEDS[1])
            chosen = runs[:2] if step == 20 else runs
            assert together.step([run.loop for run in chosen]) == {}
    with Run(load_experiment(name, [SMALL] if "husky" in name else [])) as run:
        run.loop.reset(seed=SEEDS[1])
        run.run_until(runs[1].now_s)
        assert runs[1].snapshot() == run.snapshot()
    for run in runs[::-1]:
        run.close()
