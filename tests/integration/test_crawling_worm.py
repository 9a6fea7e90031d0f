"""The worm's gait against the program of Boyle, Berri and Cohen (2012), whose numbers are the criteria's."""

from __future__ import annotations

from pathlib import Path

import nrp_experiments
import numpy as np
import pytest
from nrp_experiments.bodies.worm import Worm, sdf

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

WORM, BODIES = Worm(), Path(nrp_experiments.__file__).parent / "bodies"


def wave(name: str, world: str, *overrides: str) -> dict[str, float]:
    """Return the last frequency (Hz) and wavelength (body lengths) of a run that passed."""
    with Run(load_experiment(name, [f"world.backend={world}", *overrides])) as run:
        heard = {each: run.world.subscribe(f"/worm/{each}") for each in ("frequency", "wavelength")}
        run.run()
        assert run.result().passed
        return {each: topic.latest.message.data for each, topic in heard.items() if topic.latest}


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["crawling_worm", "crawling_worm/in_water"])
def test_both_engines_agree_on_the_gait(name: str) -> None:
    one, other = (wave(name, world) for world in ("mujoco", "pybullet"))
    assert one["frequency"] == pytest.approx(other["frequency"], rel=0.05)
    assert one["wavelength"] == pytest.approx(other["wavelength"], rel=0.1)


@pytest.mark.heavy
def test_the_wave_is_gone_without_proprioception() -> None:
    assert "frequency" not in wave("crawling_worm/without_proprioception", "mujoco")


@pytest.mark.heavy
def test_at_least_four_of_five_rewired_worms_do_not_crawl() -> None:
    crawl = 0
    for seed in range(1, 6):
        controls = "brain.controls=[{rewire: degree_preserving}]"
        with Run(load_experiment("crawling_worm", [f"seed={seed}", controls])) as run:
            run.run_until(7.0)
            x, y, _ = run.world.engine.model_motion("worm").pose.position
            crawl += np.hypot(x, y) > 0.5
    assert crawl <= 1


def test_the_worms_first_bend_comes_from_its_muscles() -> None:
    """Without drag and damping, the torques balance the walls where the bend is at rest."""
    dorsal, nothing, still = np.full(WORM.segments, 0.5), np.zeros(WORM.segments), np.zeros(WORM.segments)
    shorter = WORM.shrinking * WORM.radius / (WORM.thick / 2) * WORM.rest
    wall, muscle = 1.0, 20 * 0.5
    pulled = muscle * 0.5 * shorter  # a force along the dorsal side
    bend = -pulled / ((2 * wall + muscle) * WORM.radius)
    assert WORM.torques(dorsal, nothing, bend, still) == pytest.approx(WORM.stiffness * bend, rel=1e-12)
    assert (bend < 0).all()  # the dorsal side is the shorter one


@pytest.mark.parametrize("medium", ["on_agar", "in_water"])
def test_the_worms_files_equal_the_output_of_their_generator(medium: str) -> None:
    assert sdf(WORM, medium.split("_")[1]) == (BODIES / f"worm_{medium}.sdf").read_text()
