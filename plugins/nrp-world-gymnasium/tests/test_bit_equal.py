"""A world gives what a loop of env.step gives, bit for bit, across ends of episodes, resets and snapshots."""

import gymnasium
import numpy as np
import pytest
from nrp_world_gymnasium.episodes import Episodes

from nrp_core.messages.std_msgs import Float64, Int32

ENVIRONMENTS = {
    "CartPole-v1": ("20 ms", lambda n: Int32(int(n * 0.37) % 2), lambda m: np.int64(m.data)),
    "Pendulum-v1": (
        "50 ms",
        lambda n: Float64(2.0 * np.sin(n / 5)),
        lambda m: np.array([m.data], np.float32),
    ),
}
STEPS = 450  # 20 episodes of CartPole or more, and two of Pendulum


@pytest.fixture(params=ENVIRONMENTS)
def env(request):
    return request.param


def in_a_loop(env, seed, steps=STEPS):
    """Return observations, rewards and ends of a loop that resets after each end, as its users write it."""
    _, make, decode = ENVIRONMENTS[env]
    bare = gymnasium.make(env)
    rows, ended = [(bare.reset(seed=seed)[0].astype(float).tolist(), 0.0, False, False)], False
    for n in range(steps):
        if ended:
            seen, reward, terminated, truncated = bare.reset()[0], 0.0, False, False
        else:
            seen, reward, terminated, truncated, _ = bare.step(decode(make(n)))
        ended = terminated or truncated
        rows.append((seen.astype(float).tolist(), float(reward), terminated, truncated))
    bare.close()
    return rows


def opened(open_world, env, **options):
    world = open_world(env, timestep=ENVIRONMENTS[env][0], **options)
    return world, [world.subscribe(f"/env/{n}") for n in ("observation", "reward", "terminated", "truncated")]


def in_a_world(world, topics, env, steps=STEPS, start=0):
    """Return the same from the topics of a world; the first row is the state at the start."""
    make, step_ns = ENVIRONMENTS[env][1], world.capabilities.step_ns
    action, rows = world.advertise("/env/action"), []
    for n in range(start, start + steps):
        action.publish(make(n))
        world.run_until(world.now_ns + step_ns)
        seen, *about = (topic.latest.message.data for topic in topics)
        rows.append((seen.tolist(), *about))
    return rows


@pytest.mark.parametrize("seed", [3, 4])
def test_a_world_equals_a_loop_of_steps(open_world, env, seed):
    world, topics = opened(open_world, env, seed=seed)
    rows = in_a_world(world, topics, env)
    assert rows == in_a_loop(env, seed)[1:]
    ends = sum(row[2] or row[3] for row in rows)
    assert world.engine.episodes.number == ends >= 2


def test_the_first_message_is_the_observation_of_the_reset(open_world, env):
    world, _ = opened(open_world, env)
    seen = world.subscribe("/env/observation", depth=2)
    world.run_until(world.capabilities.step_ns)
    assert seen.messages[0].t_ns == 0
    assert seen.messages[0].message.data.tolist() == in_a_loop(env, 1, steps=0)[0][0]


def test_an_engine_that_repeats_the_first_episode_is_seen(open_world, monkeypatch):
    """The comparison finds a wrong engine: each of its episodes has the first seed."""

    def step(self, right=Episodes.step):
        if self.terminated or self.truncated:
            self.env.reset(seed=1)
            self.env.unwrapped.np_random = np.random.default_rng(1)
        right(self)

    monkeypatch.setattr(Episodes, "step", step)
    world, topics = opened(open_world, "CartPole-v1")
    assert in_a_world(world, topics, "CartPole-v1") != in_a_loop("CartPole-v1", 1)[1:]


def test_a_reset_and_a_snapshot_lead_to_the_same_run(open_world, env):
    world, topics = opened(open_world, env)
    first = in_a_world(world, topics, env, steps=120)
    snapshot = world.snapshot()
    expected = in_a_world(world, topics, env, steps=120, start=120)
    world.restore(snapshot)
    assert in_a_world(world, topics, env, steps=120, start=120) == expected
    other, others = opened(open_world, env)
    other.restore(snapshot)
    assert in_a_world(other, others, env, steps=120, start=120) == expected
    world.reset()
    assert in_a_world(world, topics, env, steps=120) == first
    world.reset(seed=2)
    assert in_a_world(world, topics, env, steps=120) == in_a_loop(env, 2, steps=120)[1:]


def test_an_action_holds_and_a_split_run_is_the_same_run(open_world, env):
    (one, seen), (two, others) = (opened(open_world, env) for _ in range(2))
    for world in (one, two):
        world.advertise("/env/action").publish(ENVIRONMENTS[env][1](3))
    one.run_until(60 * one.capabilities.step_ns)
    for n in range(1, 61):
        two.run_until(n * two.capabilities.step_ns)
    assert seen[0].latest.message.data.tolist() == others[0].latest.message.data.tolist()
    one.reset()
    one.run_until(60 * one.capabilities.step_ns)
    fresh, again = opened(open_world, env)
    fresh.run_until(60 * one.capabilities.step_ns)
    assert seen[0].latest.message.data.tolist() == again[0].latest.message.data.tolist(), (
        "a reset keeps a command"
    )


def test_a_held_environment_stays_at_its_end(open_world):
    world, (seen, *_, terminated, _) = opened(open_world, "CartPole-v1", at_end="hold")
    world.run_until(60 * world.capabilities.step_ns)  # 0 pushes to the left: it falls within 11 steps
    assert (terminated.latest.message.data, world.engine.episodes.number) == (True, 0)
    last = seen.latest.message.data.tolist()
    world.run_until(90 * world.capabilities.step_ns)
    assert seen.latest.message.data.tolist() == last
    assert world.engine.episodes.number == 0
