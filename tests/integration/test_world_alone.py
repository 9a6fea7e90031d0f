"""The world of an experiment without its brain."""

from __future__ import annotations

import pytest
from golden import Golden

from nrp_core import Experiment, load_experiment, open_world, running
from nrp_core.errors import ExperimentError, LifecycleError, TopicError
from nrp_core.experiment.model.collector import Collector
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.world import World


def test_the_world_of_an_experiment_opens_without_a_brain_and_has_its_aliases() -> None:
    with open_world("braitenberg_husky") as world:
        screen = world.subscribe("/left_vr_screen/body/screen_glass/color")
        world.advertise("/screens/left/color").publish(ColorRGBA(1.0, 0.0, 0.0, 1.0))
        world.advertise("/husky/cmd_vel").publish(Twist(Vector3(0.5)))
        world.run_until(1_000_000_000)
        x, y, _ = world.model_motion("husky").pose.position
        assert screen.latest is not None
        assert (screen.latest.message.r, screen.latest.message.g) == (1.0, 0.0)
    # it looks along -x, and its commandTimeout of 0.1 s ends the command: 0.5 m/s x 0.1 s
    assert (x, y) == pytest.approx((-0.05, 0.0), abs=1e-3)


def test_a_world_whose_topics_do_not_fit_the_experiment_is_closed(
    monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    opened: list[World] = []

    def refuse(experiment: Experiment, world: World, collector: Collector) -> bool:
        opened.append(world)
        raise TopicError("the real world has this topic already")

    monkeypatch.setattr(running, "declare_own", refuse)
    with golden.raises(TopicError):
        open_world(load_experiment("braitenberg_husky"))
    with golden.raises(LifecycleError):
        opened[0].run_until(20_000_000)


def test_only_an_experiment_has_a_world(golden: Golden) -> None:
    with golden.raises(ExperimentError):
        open_world("nope")
