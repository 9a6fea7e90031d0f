"""Bodies that another process simulates: they do what their simulator does, and their end is one error."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from nrp_conformance.world.kit import BLUE, RED, at, floor, pendulum, prop, robot, screen, states, twist
from nrp_core import worlds
from nrp_core.errors import LifecycleError, SimulationError
from nrp_core.messages.base import Duration
from nrp_core.messages.cdr import Codec
from nrp_core.messages.geometry_msgs import Vector3, Wrench
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.world import Box, ModelMotion, Scene, Sphere, Stamped, World

from conftest import DOMAIN, Programs, needs_ros2
from nrp_world_ros import RosBackend, RosOptions
from nrp_world_ros.joining import join
from nrp_world_ros.node import DEPTH, Letter
from nrp_world_ros.options import Ros

if TYPE_CHECKING:  # a process of a test imports this module, too, without pytest's paths
    from golden import Golden

pytestmark = pytest.mark.usefixtures("no_idle_bodies")

SCENE = Scene((
    floor(), robot(), pendulum(), screen("screen", 0.0, BLUE),
    prop("box", Box((0.3, 0.3, 0.3)), at(0.9, 0.05, 0.16), mass=1.0),
))  # fmt: skip
STEP_NS = 20_000_000


def hosted(scene: Scene = SCENE, seed: int = 1, **body_options: Any) -> World:
    options = RosOptions(body="mujoco", body_options=body_options, domain=DOMAIN)
    return RosBackend().open(scene, seed=seed, options=options)


def here(scene: Scene = SCENE, seed: int = 1) -> World:
    backend = worlds().load("mujoco")
    return backend.open(scene, seed=seed, options=backend.options())


def stamp_and_bytes(stamped: Stamped | None) -> tuple[int, bytes]:
    assert stamped is not None
    return stamped.t_ns, bytes(Codec().encode(stamped.message))


def process_of(world: World) -> int:
    return int(world.engine._host._process.pid)  # type: ignore[attr-defined]


@pytest.fixture
def world() -> Iterator[World]:
    with hosted() as world:
        yield world


def go(world: World, steps: int, turn: float = 0.3) -> None:
    command = world.advertise("/robot/cmd_vel")
    for _ in range(steps):
        command.publish(twist(0.5, turn))
        world.run_until(world.now_ns + STEP_NS)


# -- it behaves like its simulator


def paused(world: World) -> None:
    world.call("/gazebo/pause_physics")
    world.run_until(world.now_ns + 5 * STEP_NS)
    world.call("/gazebo/unpause_physics")


def pushed(world: World) -> None:
    asked = {"wrench": Wrench(Vector3(0.0, 3.0)), "duration": Duration(0, 110_000_000)}
    world.call("/gazebo/apply_body_wrench", "box::link", **asked)


def spawned(world: World) -> None:
    world.spawn(prop("ball", Sphere(0.2), at(0, 3, 1), mass=1.0))
    world.spawn(robot("late", y=2.0))
    world.advertise("/late/cmd_vel").publish(twist(0.4, 0.0))
    world.delete("box")


def painted(world: World) -> None:
    world.set_material("screen/link/visual", RED, glows=True)


def placed(world: World) -> None:
    world.place("box", ModelMotion(at(1.0, 1.0, 0.5, yaw=pi / 3).inverse()))
    world.set_joints("pendulum", {"joint": 0.2})


def started_over(world: World) -> None:
    spawned(world)
    world.reset("state")


def went_home(world: World) -> None:
    world.reset("poses")


def went_back(world: World) -> None:
    snapshot = world.snapshot()
    go(world, 3, turn=-1.0)
    world.restore(snapshot)


def went_far(world: World) -> None:
    world.run_until(world.now_ns + 2 * DEPTH * world.capabilities.step_ns)


@pytest.mark.one_of(6)
@needs_ros2
@pytest.mark.parametrize(
    "happens",
    [paused, pushed, spawned, painted, placed, started_over, went_back, went_far, went_home],
    ids=lambda happens: happens.__name__,
)
def test_a_simulated_body_does_bit_for_bit_what_it_does_in_this_process(
    world: World, happens: Callable[[World], None]
) -> None:
    with here() as other:
        seen = []
        for each in (world, other):
            odometry = each.subscribe("/robot/odom", depth=10_000)
            images = each.subscribe("/robot/camera")
            go(each, 8)
            happens(each)
            go(each, 8)
            heard = [stamp_and_bytes(stamped) for stamped in (*odometry.since(-1), images.latest)]
            joints = each.subscribe("/pendulum/joint_states").latest
            image = each.engine.render("robot", "eye", "camera")
            seen.append(
                (states(each), heard, stamp_and_bytes(joints), image.tobytes(), each.topics, each.warnings)
            )
        assert seen[0] == seen[1]


@pytest.mark.heavy
@needs_ros2
def test_worlds_that_run_side_by_side_do_not_hear_each_other() -> None:
    turns = (0.0, 0.5, -0.5)
    with ExitStack() as opened, ThreadPoolExecutor() as pool:
        together = [opened.enter_context(hosted()) for _ in turns]
        list(pool.map(go, together, [20] * len(turns), turns))
        assert len({process_of(each) for each in together}) == len(turns)
        for each, turn in zip(together, turns, strict=True):
            with here() as alone:
                go(alone, 20, turn)
                assert states(each) == states(alone)


@needs_ros2
def test_options_of_the_simulator_are_its_own() -> None:
    with hosted(image_scale=0.5, timestep="4 ms") as world:
        images = world.subscribe("/robot/camera")
        world.run_until(STEP_NS)
        assert images.latest is not None
        assert images.latest.message.data.shape == (16, 24, 3)
        assert world.engine.image_size("robot", "eye", "camera") == (16, 24)
        assert world.capabilities.step_ns == 4_000_000


@needs_ros2
def test_the_process_of_a_world_that_was_closed_serves_the_next() -> None:
    with hosted() as first:
        process = process_of(first)
    with hosted(Scene((floor(), robot("other"))), seed=7) as second:
        assert process_of(second) == process
        assert second.seed == 7
        assert "/other/odom" in second.topics


@needs_ros2
def test_others_in_ros_can_watch_it(world: World) -> None:
    there = world.engine._node._namespace  # type: ignore[attr-defined]
    with join(Ros.TWO, "watcher", domain=DOMAIN) as watcher:
        watcher.listen(f"{there}/robot/odom", Odometry)
        Programs.until(lambda: watcher.settle(10) == set())
        go(world, 3)
        last = watcher.inbox.last
        assert watcher.inbox.wait(lambda: last(f"{there}/robot/odom") is not None, 60, watcher.check)


@needs_ros2
def test_a_topic_without_its_last_listener_is_not_sent(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    came: list[str] = []
    inbox = world.engine._node.inbox  # type: ignore[attr-defined]
    take = inbox.take

    def taken() -> list[Letter]:
        letters: list[Letter] = take()
        came.extend(letter.topic for letter in letters)
        return letters

    monkeypatch.setattr(inbox, "take", taken)
    for _ in range(2):
        heard = world.subscribe("/robot/camera")
        go(world, 4)
        assert "/robot/camera" in came
        world.unsubscribe(heard)
        came.clear()
        go(world, 4)
        assert "/robot/camera" not in came


# -- what goes wrong


@needs_ros2
def test_the_death_of_one_body_process_is_one_error_and_spares_the_others(
    world: World, golden: Golden
) -> None:
    with hosted() as other:
        go(world, 3)
        os.kill(process_of(world), signal.SIGKILL)
        with pytest.raises(SimulationError, match=r"'mujoco'.*signal 9"):
            go(world, 100)
        with pytest.raises(LifecycleError):
            go(world, 1)
        with golden.raises(SimulationError):
            world.reset()
        world.close()
        go(other, 3)
    with hosted() as again:
        go(again, 1)


@needs_ros2
@pytest.mark.parametrize(
    "attempt",
    [
        lambda world: world.spawn(robot()),
        lambda world: world.delete("nobody"),
        lambda world: world.link_motion("robot", "nose"),
        lambda world: world.set_joints("pendulum", {"joint": float("inf")}),
        lambda world: world.call("/gazebo/set_model_statt"),
        lambda world: world.advertise("/screen/link/visual/color").publish(ColorRGBA(2.0)),
    ],
)
def test_a_hosted_body_refuses_the_same_requests(world: World, attempt: Callable[[World], object]) -> None:
    refused = []
    with here() as other:
        for each in (world, other):
            with pytest.raises(Exception, match=r".") as raised:
                attempt(each)
            refused.append((raised.type, str(raised.value)))
            go(each, 1)
        assert refused[0] == refused[1]
        assert states(world) == states(other)


@needs_ros2
@pytest.mark.skipif(sys.platform == "win32", reason="exit codes of signals differ")
def test_a_body_ends_with_the_process_that_needs_it() -> None:
    script = (
        "from test_hosted import hosted, process_of\n"
        "world = hosted()\n"
        "print(process_of(world), flush=True)\n"
        "world.run_until(10**12)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parent
    ) as loop:
        assert loop.stdout is not None
        body = int(loop.stdout.readline())
        loop.kill()
    Programs.until(lambda: not _runs(body), timeout_s=60)


@needs_ros2
@pytest.mark.skipif(sys.platform == "win32", reason="exit codes of signals differ")
def test_a_body_that_hangs_is_given_up(golden: Golden) -> None:
    options = RosOptions(body="mujoco", domain=DOMAIN, patience="2 s")
    with RosBackend().open(SCENE, seed=1, options=options) as world:
        body = process_of(world)
        go(world, 1)
        os.kill(body, signal.SIGSTOP)
        with golden.raises(SimulationError):
            go(world, 1)
    Programs.until(lambda: not _runs(body), timeout_s=60)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True
