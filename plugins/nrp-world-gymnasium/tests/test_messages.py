"""Spaces become typed messages, and wrong actions, scenes and options one clear error each."""

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import CapabilityError, DivergedError, ExperimentError, SnapshotError, TopicError
from nrp_core.findings import Code
from nrp_core.messages.std_msgs import Bool, Float64MultiArray, Int32
from nrp_core.world import Link, Model, Scene

CORRIDOR = "tests/Corridor-v0"
STEP_NS = 20_000_000


def types(world):
    return {name: info.type.__name__ for name, info in world.topics.items() if name.startswith("/env")}


def test_each_part_of_a_space_has_a_topic_with_its_message(open_world):
    world = open_world(CORRIDOR, image=True)
    assert types(world) == {
        "/env/observation/eye": "Image", "/env/observation/map": "Float64MultiArray",
        "/env/observation/mission": "String", "/env/action/steps": "Int32",
        "/env/action/turns": "Float64MultiArray", "/env/reward": "Float64", "/env/return": "Float64",
        "/env/episode": "Int32", "/env/terminated": "Bool", "/env/truncated": "Bool", "/env/image": "Image",
    }  # fmt: skip
    assert types(open_world("Blackjack-v1"))["/env/observation/2"] == "Int32"
    assert types(open_world("FrozenLake-v1"))["/env/observation"] == "Int32"
    assert types(open_world("Pendulum-v1", timestep="50 ms"))["/env/action"] == "Float64"


def test_observations_arrive_whole_and_actions_reach_the_environment(open_world):
    world = open_world(CORRIDOR, image=True)
    topics = ("observation/eye", "observation/map", "observation/mission", "reward", "return", "image")
    subscribed = [world.subscribe(f"/env/{name}", depth=3) for name in topics]
    steps, turns = world.advertise("/env/action/steps"), world.advertise("/env/action/turns")
    steps.publish(Int32(1))
    turns.publish(Float64MultiArray(data=np.array([0.25, -1.0])))
    world.run_until(2 * STEP_NS)
    eye, places, mission, reward, total, image = (each.latest.message for each in subscribed)
    assert (eye.height, eye.width, eye.encoding, eye.step) == (4, 6, "rgb8", 18)
    assert eye.data.ravel().tolist() == [2, *range(1, 72)]
    assert [each.message.data[0, 0, 0] for each in subscribed[0].messages] == [0, 1, 2], "images are kept"
    assert places.data.tolist() == [0.25, 1.25, 2.25, 3.25, 4.25, 5.25]
    assert [(each.size, each.stride) for each in places.layout.dim] == [(2, 6), (3, 3)]
    assert (mission.data, reward.data, total.data) == ("go to 2", -0.75, -1.5)
    assert (image.height, image.width, set(image.data.ravel().tolist())) == (3, 5, {7})
    for action in world.engine.episodes.env.unwrapped.taken:
        assert action in world.engine.episodes.env.action_space


@pytest.mark.parametrize(
    ("topic", "message", "error"),
    [
        ("/env/action/steps", Int32(2), "/env/action/steps.*-1"),
        ("/env/action/steps", Bool(True), "std_msgs/msg/Int32"),
        (
            "/env/action/turns",
            Float64MultiArray(data=np.array([0.0, 2.5])),
            r"/env/action/turns.*\[1\].*-1.*2.5",
        ),
        ("/env/action/turns", Float64MultiArray(data=np.zeros(3)), "/env/action/turns: .* 2 numbers, not 3"),
    ],
)
def test_an_action_outside_of_its_space_is_refused_and_breaks_nothing(
    open_world, topic, message, error, golden: Golden
):
    world = open_world(CORRIDOR)
    with golden.raises(TopicError, match=error):
        world.advertise(topic).publish(message)
    world.run_until(STEP_NS)
    assert world.engine.episodes.env.unwrapped.taken[0]["steps"] == 0


@pytest.mark.parametrize(
    ("env", "options", "kind", "error"),
    [
        ("CartPol-v1", {}, ExperimentError, "`CartPole`"),
        ("no_such_module:X-v0", {}, ExperimentError, "no_such_module"),
        ("CartPole-v1", {"arguments": {"gravitas": 1}}, ExperimentError, "gravitas"),
        ("CartPole-v1", {"first_action": 2}, ExperimentError, "Discrete.2"),
        ("CartPole-v1", {"first_action": 0.5}, ExperimentError, "Discrete.2.*0.5"),
        ("CartPole-v1", {"first_action": [0, 1]}, ExperimentError, ""),
        (CORRIDOR, {"first_action": 1}, ExperimentError, ""),
        ("tests/Graphs-v0", {}, CapabilityError, ""),
        (
            "CartPole-v1",
            {"scene": Scene((Model("husky", (Link("base"),)),))},
            CapabilityError,
            "'husky'.*'scene'.*'robots'",
        ),
    ],
)
def test_an_environment_that_cannot_be_opened_is_one_clear_error(
    open_world, env, options, kind, error, golden: Golden
):
    with golden.raises(kind, match=error):
        open_world(env, **options)


def test_the_first_action_can_be_chosen(open_world):
    ends = {}
    for action in (0, 1):
        world = open_world("CartPole-v1", first_action=action)
        place = world.subscribe("/env/observation")
        world.run_until(5 * STEP_NS)
        ends[action] = place.latest.message.data[0]
    assert ends[0] < -0.02 < 0.02 < ends[1], "1 pushes to the right"


def test_an_environment_that_forgets_cannot_be_restored_in_silence(open_world, golden: Golden):
    world = open_world("tests/Forgetful-v0")
    snapshot = world.snapshot()
    with golden.raises(SnapshotError):
        world.restore(snapshot)


def test_a_value_that_is_not_a_number_is_an_error(open_world, golden: Golden):
    world = open_world("tests/Lost-v0")
    world.run_until(STEP_NS)
    world.advertise("/env/action/steps").publish(Int32(1))
    with golden.raises(DivergedError):
        world.run_until(2 * STEP_NS)


def test_another_time_step_than_that_of_the_environment_is_reported(open_world):
    (finding,) = open_world("Pendulum-v1").warnings
    assert finding.code is Code.NRP372
    assert "simulates 50 ms, but the option 'timestep' is 20 ms" in finding.message
    assert not list(open_world("Pendulum-v1", timestep="50 ms").warnings)


def test_no_step_is_left_out_whatever_the_time_step(open_world):
    world = open_world("FrozenLake-v1", timestep="33333333 ns")
    seen = world.subscribe("/env/episode", depth=1000)
    world.run_until(999 * 33_333_333)
    assert [each.t_ns for each in seen.messages] == [n * 33_333_333 for n in range(1000)]
