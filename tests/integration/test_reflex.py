"""The arm with muscles answers a load by a stretch reflex, which depends on its circuits."""

from __future__ import annotations

import shutil
from pathlib import Path

import nrp_experiments
import numpy as np
import pytest

from nrp_core.brain import MotoneuronPool
from nrp_core.errors import TransferFunctionRaisedError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.pynn import new_simulator

BODIES = Path(nrp_experiments.__file__).parent / "bodies"


def test_rising_drive_recruits_small_units_first_and_falling_drive_releases_them_last() -> None:
    """The size principle of E. Henneman (1957), for a current that all units share."""
    sim = new_simulator()
    sim.setup(timestep=0.1)
    units = sim.Population(40, sim.IF_curr_exp(**MotoneuronPool(40).parameters()))
    drive = np.concatenate([np.linspace(0.0, 4.0, 50), np.linspace(4.0, 0.0, 50)])  # nA, each for 10 ms
    sim.StepCurrentSource(times=range(0, 1000, 10), amplitudes=drive.tolist()).inject_into(units)
    units.record("spikes")
    sim.run(1000.0)
    trains = units.get_data().segments[0].spiketrains
    first, last = (np.array([float(train[end]) for train in trains]) for end in (0, -1))
    assert (np.diff(first) >= 0).all()
    assert np.corrcoef(np.argsort(np.argsort(last)), np.arange(40))[0, 1] < -0.9


def outcome(name: str, *overrides: str) -> tuple[float, dict[str, float]]:
    """Return the share of criteria that were met, and the last value of each topic of the judges."""
    with Run(load_experiment(name, overrides)) as run:
        heard = {each: run.world.subscribe(f"/reflex/{each}") for each in ("latency", "burst", "swing")}
        run.run()
        passed = run.result().passed
        return float(passed is True), {
            each: found.latest.message.data for each, found in heard.items() if found.latest
        }


def test_pools_drive_the_muscles_of_their_names(tmp_path: Path) -> None:
    """In any order of a mapping; a muscle without a pool is an error."""
    commands, text = [], (BODIES.parent / "reflex_arm" / "reflex.py").read_text()
    pools = "of(nrp.brain.motoneurons, MOTONEURONS)"
    for changed in (pools, f"dict(reversed({pools}.items()))", f"dict([*{pools}.items()][1:])"):
        shutil.copytree(BODIES.parent / "reflex_arm", tmp_path / "reflex_arm", dirs_exist_ok=True)
        shutil.copytree(BODIES, tmp_path / "bodies", dirs_exist_ok=True)
        (tmp_path / "reflex_arm" / "reflex.py").write_text(
            text.replace(f'"/arm/muscles", {pools}', f'"/arm/muscles", {changed}')
        )
        experiment = load_experiment(str(tmp_path / "reflex_arm" / "experiment.yaml"), ["duration=60 ms"])
        with Run(experiment) as run:
            states = run.world.subscribe("/arm/muscles/state")
            if "[1:]" in changed:
                with pytest.raises(
                    TransferFunctionRaisedError, match="'shoulder_flexor' of '/arm/muscles' has no pool"
                ):
                    run.run()
                continue
            run.run()
            assert states.latest is not None
            commands.append(states.latest.message.activation)
    assert commands[0].max() > 0
    np.testing.assert_array_equal(commands[0], commands[1])


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("brain", "world"), [("event", "mujoco"), ("event", "pybullet"), ("spinnaker", "pybullet")]
)
def test_a_loaded_arm_answers_by_its_reflex(brain: str, world: str) -> None:
    passed, found = outcome("reflex_arm", f"brain.backend={brain}", f"world.backend={world}")
    assert passed
    assert 25 < found["latency"] < 100  # doi 10.1371/journal.pone.0163854
    assert found["swing"] < 0.03


def test_without_ia_fibres_the_reflex_is_gone() -> None:
    passed, found = outcome("reflex_arm/without_ia")
    assert passed
    assert abs(found["burst"]) < 1.5
    assert found["latency"] > 100


def test_with_reversed_reciprocal_inhibition_the_arm_swings() -> None:
    passed, found = outcome("reflex_arm/reversed")
    assert passed
    assert found["swing"] > 0.035


@pytest.mark.heavy
@pytest.mark.parametrize("brain", ["event", "spinnaker"])
@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
def test_every_seed_passes(brain: str, world: str) -> None:
    backends = f"brain.backend={brain}", f"world.backend={world}"
    failed = [n for n in range(1, 21) if not outcome("reflex_arm", f"seed={n}", *backends)[0]]
    assert not failed
