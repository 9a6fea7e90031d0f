"""Determinism, reset and snapshots: what a world does depends on its state alone, and that is all kept."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from golden import Golden
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.errors import DivergedError, LifecycleError, SnapshotError
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.model import Box, Joint, Link, Model, Scene, Sphere
from nrp_core.scene.rigid import Pose

STEP_NS = 20_000_000


def crowded(parts):
    """Return a scene in which the robot soon touches things: a box to push, a ball, a wall, another robot."""
    return Scene(
        (
            parts.floor(),
            parts.wall(2.5),
            parts.prop("box", Box((0.3, 0.3, 0.3)), Pose((1.0, 0.1, 0.16)), mass=2.0),
            parts.prop("ball", Sphere(0.15), Pose((-1.0, 0.0, 0.3)), mass=1.0),
            parts.husky(pose=Pose((0, 0, 0.2))),
            parts.husky("other", Pose((0.3, 1.2, 0.2))),
            parts.hanging("revolute", (0, 1, 0), lower=-0.6, upper=0.6, com=(0.3, 0.0, -0.3)),
        )
    )


class Watched:
    """A world that is driven by numbered steps, each of which depends on its number alone."""

    MODELS = ("husky", "other", "box", "ball", "hanging")

    def __init__(self, world, step: int = 0) -> None:
        self.world, self.step = world, step
        self._commands = {name: world.advertise(f"/{name}/cmd_vel") for name in ("husky", "other")}
        self._color = world.advertise("/wall/link/visual/color")

    def steps(self, count: int) -> list[bytes]:
        """Take steps and return everything that can be seen after each."""
        return [self._take() for _ in range(count)]

    def _take(self) -> bytes:
        random = np.random.default_rng(self.step)
        for commands in self._commands.values():
            if random.random() < 0.7:
                commands.publish(
                    Twist(Vector3(random.uniform(-0.5, 1)), Vector3(0, 0, random.uniform(-3, 3)))
                )
        if self.step % 5 == 3:
            self._color.publish(ColorRGBA(*random.uniform(0, 1, 3), 1.0))
        self.step += 1
        self.world.run_until(self.world.now_ns + STEP_NS)
        return self.seen()

    def seen(self) -> bytes:
        world = self.world
        motions = [world.model_motion(name) for name in self.MODELS]
        joints = [world.joint_states(name) for name in ("husky", "other", "hanging")]
        arrays = [(j.positions.tobytes(), j.velocities.tobytes(), j.efforts.tobytes()) for j in joints]
        return pickle.dumps((motions, arrays, world.engine.render("husky", "eye", "camera").tobytes()))


@pytest.fixture
def open_crowded(open_world, parts):
    return lambda: open_world(crowded(parts), image_scale=0.25)


def test_two_runs_are_equal_bit_for_bit(open_crowded):
    assert Watched(open_crowded()).steps(100) == Watched(open_crowded()).steps(100)


def test_worlds_that_take_turns_do_not_disturb_each_other(open_crowded):
    alone = Watched(open_crowded()).steps(30)
    one, two = Watched(open_crowded()), Watched(open_crowded(), step=1000)
    taken = []
    for _ in range(30):
        taken += one.steps(1)
        two.steps(1)
    assert taken == alone


def test_a_reset_world_equals_a_fresh_one(open_crowded):
    watched = Watched(open_crowded())
    fresh = watched.seen()
    expected = watched.steps(50)
    watched.steps(17)
    watched.world.reset()
    watched.step = 0
    assert watched.seen() == fresh
    assert watched.steps(50) == expected


@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(before=st.integers(0, 60), away=st.integers(0, 20), after=st.integers(1, 40))
def test_running_on_from_a_snapshot_equals_never_having_left(open_crowded, before, away, after):
    watched = Watched(open_crowded())
    watched.steps(before)
    snapshot, seen = watched.world.snapshot(), watched.seen()
    expected = watched.steps(after)
    watched.steps(away)
    for world in (watched.world, open_crowded()):
        world.restore(snapshot)
        restored = Watched(world, before)
        assert restored.seen() == seen
        assert restored.steps(after) == expected


def test_a_snapshot_can_be_taken_while_samples_and_timeouts_are_pending(open_world, parts):
    def watch(world):
        return [world.subscribe("/husky/camera", depth=100), world.subscribe("/husky/odom", depth=100)]

    def messages(subscriptions):
        return [
            [(stamped.t_ns, repr(stamped.message)) for stamped in each.messages] for each in subscriptions
        ]

    world = open_world(parts.floor(), parts.husky())
    heard = watch(world)
    world.advertise("/husky/cmd_vel").publish(Twist(Vector3(0.5), Vector3(0, 0, 0.5)))
    world.run_until(46_000_000)
    snapshot = world.snapshot()
    world.run_until(300_000_000)
    other = open_world(parts.floor(), parts.husky())
    heard_there = watch(other)
    other.restore(snapshot)
    other.run_until(300_000_000)
    assert messages(heard_there) == messages(heard)
    assert other.model_motion("husky") == world.model_motion("husky")


@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(stops=st.lists(st.integers(1, 99), max_size=8, unique=True))
def test_how_a_run_is_split_is_invisible(open_world, parts, stops):
    ends = []
    for cuts in ([], sorted(stops)):
        world = open_world(parts.floor(), parts.wall(1.0), parts.husky(pose=Pose((0, 0, 0.2))))
        world.advertise("/husky/cmd_vel").publish(Twist(Vector3(1.0), Vector3(0, 0, 2.0)))
        for stop in [*cuts, 100]:
            world.run_until(stop * 2_000_000)
        ends.append(world.model_motion("husky"))
    assert ends[0] == ends[1]


FRESH_PROCESS = """
import pickle, sys
scene, snapshot, name = pickle.loads(sys.stdin.buffer.read())
from nrp_core.world.backends import worlds
backend = worlds().load(name)
with backend.open(scene, seed=1, options=backend.options()) as world:
    world.restore(snapshot)
    world.run_until(snapshot.t_ns + 200_000_000)
    sys.stdout.buffer.write(pickle.dumps(world.model_motion("husky")))
"""


def test_a_snapshot_is_good_in_another_process_and_nothing_is_printed(backend, open_world, parts):
    scene = Scene((parts.floor(), parts.wall(1.0), parts.husky(pose=Pose((0, 0, 0.2)))))
    world = open_world(scene)
    world.advertise("/husky/cmd_vel").publish(Twist(Vector3(1.0), Vector3(0, 0, 2.0)))
    world.run_until(60_000_000)
    snapshot = world.snapshot()
    world.run_until(260_000_000)
    name = type(world.engine).__module__.split(".")[0].removeprefix("nrp_world_")
    done = subprocess.run(
        [sys.executable, "-c", FRESH_PROCESS],
        input=pickle.dumps((scene, snapshot, name)),
        capture_output=True,
        check=True,
        timeout=300,
    )
    printed = done.stderr.splitlines()
    assert [line for line in printed if not line.startswith(b"compiling the numeric kernels")] == []
    assert pickle.loads(done.stdout) == world.model_motion("husky")


def test_a_snapshot_of_another_scene_or_engine_is_refused(engines, parts):
    one, two = Scene((parts.floor(),)), Scene((parts.floor(0.5),))
    worlds = [
        backend.open(scene, seed=1, options=backend.options()) for backend in engines for scene in (one, two)
    ]
    snapshot = worlds[0].snapshot()
    for world in worlds[1:]:
        with pytest.raises(SnapshotError):
            world.restore(snapshot)
    for world in worlds:
        world.close()


@pytest.mark.filterwarnings("error")
def test_divergence_is_an_error_and_a_reset_cures_it(open_world, parts, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    heavy = parts.hanging("continuous", (0, 1, 0), com=(1e-3, 0, 0))
    ball = parts.prop("ball", Sphere(0.1), Pose((0, 0, 5)), mass=1.0)
    world = open_world(Scene((heavy, ball), gravity=(0, 0, float("nan"))))
    with pytest.raises(DivergedError):
        world.run_until(2_000_000_000)
    with pytest.raises(LifecycleError):
        world.run_until(3_000_000_000)
    world.reset()
    assert world.model_motion("ball").pose.position == (0, 0, 5)
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())


def test_a_closed_world_takes_nothing_more(open_world, parts, golden: Golden):
    world = open_world(parts.floor(), parts.husky())
    world.close()
    world.close()
    with golden.raises(LifecycleError):
        world.run_until(STEP_NS)
    with golden.raises(LifecycleError):
        world.reset()


def test_divergence_of_a_joint_of_something_anchored_is_noticed(open_world, parts):
    hanging = parts.hanging("prismatic", (1, 0, 0))
    base = Link("base")
    joint = replace(hanging.joints[0], parent="base")
    anchor = Joint("anchor", "fixed", "world", "base")
    anchored = Model("arm", (base, *hanging.links), (anchor, joint))
    world = open_world(Scene((anchored,), gravity=(float("nan"), 0, 0)))
    with pytest.raises(DivergedError):
        world.run_until(20_000_000)


def test_subscriptions_do_not_change_the_physics(open_world, parts):
    ends = []
    for watched in (False, True):
        world = open_world(crowded(parts), image_scale=0.1)
        if watched:
            world.subscribe("/husky/camera")
            world.subscribe("/other/odom")
        robot = Watched(world)
        robot.steps(40)
        ends.append([world.model_motion(name) for name in robot.MODELS])
    assert ends[0] == ends[1]
