"""A function adds dopamine to the cells of a projection that learns from rewards."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from golden import Golden

from nrp_core.brain import builder
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.testing import MockBrain, MockWorld, Rig
from nrp_core.errors import ExperimentError
from nrp_core.network.data import Network

Load = Callable[[str], list[TransferFunction]]


def network() -> Network:
    sim = builder()
    a, b, c = (sim.Population(2, sim.IF_curr_exp(), label=label) for label in "abc")
    rule = sim.STDPMechanism(sim.SpikePairRule(), sim.AdditiveWeightDependence(), weight=0.5, delay=1.0)
    each = sim.OneToOneConnector()
    sim.Projection(a, b, each, sim.StaticSynapse(weight=0.5, delay=1.0), label="static")
    sim.Projection(a, b, each, rule, label="learned")
    sim.Projection(a, c, each, rule, label="alone")
    sim.Projection(c, b, each, sim.Neuromodulation(0.1), receptor_type="reward", label="dopamine")
    return sim.network()


def function_with(load: Load, body: str, projection: str = "learned", settings: str = "") -> TransferFunction:
    lines = "\n            ".join(body.splitlines())
    (function,) = load(
        f"""
        @nrp.MapReward("r", nrp.brain.projection("{projection}"){settings})
        @nrp.Robot2Neuron()
        def f(t, r):
            {lines}
        """
    )
    return function


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("r.value = 0.25", [0.25, 0.25]),
        ("r.value = -t", [-0.02]),
        ("r.value += 1\nr.value += 2", [3.0, 3.0]),
        ("if t == 0: r.value = 2", [2.0]),
        ("pass", []),
    ],
)
def test_a_reward_is_added_after_its_function_has_returned(
    load: Load, body: str, expected: list[float]
) -> None:
    brain = MockBrain(network())
    rig = Rig(function_with(load, body), brain)
    rig.run(0.0)
    rig.run(0.02)
    assert brain.rewards == [("b", amount) for amount in expected]
    brain.reset()
    assert brain.rewards == []


@pytest.mark.parametrize(
    ("body", "error", "message"),
    [
        ("r.value = 1.0\nraise RuntimeError('late')", RuntimeError, "late"),
        ("r.value = float('nan')", ValueError, "r.value"),
        ("r.value = [1.0]", ValueError, ""),
        ("r.held = 1.0\nraise RuntimeError('late')", RuntimeError, "late"),
        ("r.held = float('inf')", ValueError, "r.held"),
        ("r.values = 1.0", AttributeError, "'values'"),
        ("r.baseline = 1.0", AttributeError, "'baseline'"),
    ],
)
def test_a_function_that_fails_rewards_nothing(
    load: Load, body: str, error: type[Exception], message: str, golden: Golden
) -> None:
    brain = MockBrain(network())
    rig = Rig(function_with(load, body), brain)
    with golden.raises(error, match=message):
        rig.run()
    assert (brain.rewards, brain.held_rewards) == ([], {})


def test_a_value_is_held_until_the_next_call(load: Load) -> None:
    brain = MockBrain(network())
    rig = Rig(function_with(load, "if t < 0.03: r.held = 1.0 - 50 * t"), brain)
    seen = []
    for t in (0.0, 0.02, 0.04):
        rig.run(t)
        seen.append(brain.held_rewards["b"])
    assert seen == [1.0, 0.0, 0.0]
    rig.run(0.0)
    rig.function.active = False
    assert brain.held_rewards["b"] == 0.0
    rig.function.active = True
    rig.run(0.0)
    rig.function.unbind()
    assert (brain.held_rewards["b"], brain.rewards) == (0.0, [])


def test_a_function_holds_nothing_that_it_never_set(load: Load) -> None:
    brain = MockBrain(network())
    brain.hold_reward("learned", 2.0)
    Rig(function_with(load, "r.value = 1.0"), brain).run()
    assert brain.held_rewards == {"b": 2.0}


def test_the_running_mean_of_rewards_is_subtracted(load: Load) -> None:
    """From 0, each reward moves it by a fourth of the difference; calls without a reward do not."""
    brain = MockBrain(network())
    body = "r.held = 8.0\nif t != 0.02: r.value = 100 * t - r.baseline * 0"
    rig = Rig(function_with(load, body, settings=", baseline=4"), brain)
    held = []
    for t in (0.0, 0.01, 0.02, 0.03, 0.04):
        rig.run(t)
        held.append(brain.held_rewards["b"])
    means = [0.0, 0.25, 0.25 + 2.75 / 4]
    assert [amount for _, amount in brain.rewards] == pytest.approx(
        [1.0, 3.0 - means[1], 4.0 - means[2]], rel=1e-12
    )
    assert held == pytest.approx([8.0 * 0.75**n for n in range(5)], rel=1e-12)
    saved = rig.function.save()
    rig.function.reset()
    rig.run(0.01)
    assert brain.rewards[-1] == ("b", 1.0)
    rig.function.restore(saved)
    rig.run(0.04)
    assert brain.rewards[-1][1] == pytest.approx(4.0 - (means[2] + (4.0 - means[2]) / 4), rel=1e-12)


@pytest.mark.parametrize("given", ["0.5", "True", "float('inf')", "'10'"])
def test_a_baseline_is_a_number_of_rewards(load: Load, given: str, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        function_with(load, "pass", settings=f", baseline={given}")


@pytest.mark.parametrize(
    ("projection", "message"),
    [
        ("learnt", "no projection 'learnt'"),
        ("static", "'static'.*STDP"),
        ("alone", "'alone'.*'c'"),
        ("dopamine", "'dopamine'.*'b'"),
    ],
)
def test_a_projection_that_cannot_learn_from_rewards_is_refused(
    load: Load, projection: str, message: str, golden: Golden
) -> None:
    with golden.raises(ExperimentError, match=message) as caught:
        function_with(load, "pass", projection).bind(MockBrain(network()), MockWorld({}))
    assert caught.value.line is not None
