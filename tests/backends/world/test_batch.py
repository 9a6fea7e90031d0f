"""Many copies of a scene in one process: each does what it would do alone, and no failure harms another."""

from __future__ import annotations

from contextlib import ExitStack

import numpy as np
import pytest
from golden import Golden
from jointed import HANGING, axis, joint

from nrp_core.errors import DivergedError, LifecycleError, SimulationError, TopicError
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.devices import Noise
from nrp_core.scene.model import Box, Scene
from nrp_core.scene.rigid import ModelMotion, Pose, ServoTarget
from nrp_core.simulation import State
from nrp_core.world.batch import advance_together, release_together

STEP_NS = 20_000_000
SEEDS = (3, 1, 4, 1, 5)
STEPS = 60


@pytest.fixture
def scene(parts):
    """Return a robot with a noisy camera, a box to push and something that swings."""
    box = parts.prop("box", Box((0.3, 0.3, 0.3)), Pose((0.8, 0.1, 0.16)), mass=2.0)
    robot = parts.husky(pose=Pose((0, 0, 0.2)), noise=Noise(stddev=0.05))
    return Scene((parts.floor(), box, robot, parts.hanging("revolute", (0, 1, 0), com=(0.3, 0.0, -0.3))))


@pytest.fixture
def batch(backend, scene):
    with backend.open_batch(scene, seeds=SEEDS, options=backend.options(), threads=0) as batch:
        yield batch


def commands(step):
    """Return a command for each copy, all different."""
    random = np.random.default_rng(step)
    rows = np.zeros((len(SEEDS), 6))
    rows[:, 0], rows[:, 5] = random.uniform(0, 0.8, len(SEEDS)), random.uniform(-1, 1, len(SEEDS))
    return rows


def drive(batch):
    publication = batch.advertise("/husky/cmd_vel")
    for step in range(STEPS):
        publication.publish(commands(step))
        batch.run_until(batch.now_ns + STEP_NS)


def test_commands_that_copies_take_at_once_act_as_those_of_each(backend, scene, batch):
    """Some stay as they are, turn round, stop, or are larger than any robot's."""
    topic, random = "/husky/cmd_vel", np.random.default_rng(5)
    choices = [0.0, -0.0, 0.2, 0.7, -0.5, 60.0, -60.0]
    with backend.open_batch(scene, seeds=SEEDS, options=backend.options(), threads=0) as others:
        ways = [(copies, [world.advertise(topic) for world in copies.worlds]) for copies in (batch, others)]
        for _ in range(STEPS):
            rows = np.zeros((len(SEEDS), 6))
            rows[:, [0, 5]] = random.choice(
                choices, (len(SEEDS), 2), p=[0.3, 0.1, 0.2, 0.2, 0.18, 0.01, 0.01]
            )
            for copies, publications in ways:
                for world, publication, row in zip(copies.worlds, publications, rows.tolist(), strict=True):
                    world.hold_messages()
                    publication.publish_numbers(row)
                if copies is batch:
                    assert release_together(copies.worlds) == {}
                else:
                    for world in copies.worlds:
                        world.release_messages()
                copies.run_until(copies.now_ns + STEP_NS)
            assert np.array_equal(batch.motions("husky"), others.motions("husky"))
        states = [[world.snapshot().payload for world in copies.worlds] for copies in (batch, others)]
        assert states[0] == states[1]


def test_every_copy_is_bit_for_bit_what_it_is_alone(backend, scene, batch):
    cameras = batch.subscribe("/husky/camera")
    drive(batch)
    robots, joints = batch.motions("husky"), batch.joint_states("husky")
    boxes, bobs = batch.motions("box"), batch.joint_states("hanging")
    for copy, seed in enumerate(SEEDS):
        with backend.open(scene, seed=seed, options=backend.options()) as alone:
            camera, publication = alone.subscribe("/husky/camera"), alone.advertise("/husky/cmd_vel")
            for step in range(STEPS):
                forward, *_, turn = commands(step)[copy].tolist()
                publication.publish(Twist(Vector3(forward), Vector3(z=turn)))
                alone.run_until(alone.now_ns + STEP_NS)
            motion, box = alone.model_motion("husky"), alone.model_motion("box")
            assert (*motion.pose.position, *motion.pose.orientation) == tuple(robots[copy, :7].tolist())
            assert (*motion.linear, *motion.angular) == tuple(robots[copy, 7:].tolist())
            assert box.pose.position == tuple(boxes[copy, :3].tolist())
            for name, stacked in (("husky", joints), ("hanging", bobs)):
                states = alone.joint_states(name)
                assert states.names == stacked.names
                assert (states.positions == stacked.positions[copy]).all()
                assert (states.velocities == stacked.velocities[copy]).all()
                assert (states.efforts == stacked.efforts[copy]).all()
            assert camera.latest.t_ns == cameras[copy].latest.t_ns
            assert np.array_equal(camera.latest.message.data, cameras[copy].latest.message.data)


def forces(world):
    """Return what a state does not hold: contacts and forces of the last step; and motions."""
    wrench = world.engine.joint_wrench("hanging", "joint")
    return list(world.engine.touches()), wrench, world.link_motion("hanging", "bob")


def test_forces_of_the_last_step_are_those_alone_when_all_copies_have_taken_it(backend, scene, batch):
    publication, felt = batch.advertise("/husky/cmd_vel"), []
    for step in range(4):
        batch.run_until(batch.now_ns + STEP_NS)
        publication.publish(commands(step))
        if step:  # for the first time after several steps
            felt.append([forces(world) for world in batch.worlds])
    for copy, seed in enumerate(SEEDS[:2]):
        with backend.open(scene, seed=seed, options=backend.options()) as alone:
            publication = alone.advertise("/husky/cmd_vel")
            for step in range(4):
                alone.run_until(alone.now_ns + STEP_NS)
                forward, *_, turn = commands(step)[copy].tolist()
                publication.publish(Twist(Vector3(forward), Vector3(z=turn)))
                if step:
                    assert repr(forces(alone)) == repr(felt[step - 1][copy])
            assert forces(alone)[0]


def test_a_copy_reads_its_links_also_after_another_one_has_moved(batch):
    drive(batch)
    one, other, *_ = batch.worlds
    before = one.link_motion("hanging", "bob")
    other.engine.advance(1)
    assert one.link_motion("hanging", "bob") == before


SERVO = """<plugin filename="gz-sim-joint-position-controller-system"
  name="gz::sim::systems::JointPositionController"><joint_name>j</joint_name><p_gain>20</p_gain></plugin>"""


def test_forces_of_the_last_step_do_not_depend_on_later_gains(backend, read):
    scene = Scene((read(HANGING + joint("revolute", axis("0 1 0")) + SERVO),))

    def felt(world):
        world.run_until(STEP_NS)
        world.engine.set_servo_target("robot", "j", ServoTarget(50.0, 0.1, effort=3.0))
        world.run_until(2 * STEP_NS)
        world.engine.set_servo_target("robot", "j", ServoTarget(effort=-1.0))
        return world.engine.joint_wrench("robot", "j")

    with backend.open_batch(scene, seeds=SEEDS[:2], options=backend.options(), threads=0) as batch:
        copied = felt(batch.worlds[1])
    with backend.open(scene, seed=SEEDS[1], options=backend.options()) as alone:
        assert felt(alone) == copied


def act(world, choice, value, saved):
    """Change the gains and the target of a servo, reset, save, or restore what was saved."""
    if choice == "reset":
        world.reset()
    elif choice == "save":
        saved[:] = [world.snapshot()]
    elif choice == "restore" and saved:
        world.restore(saved[0])
    else:
        world.engine.set_servo_target("robot", "j", ServoTarget(10.0 + value, 0.1 * value, effort=value))


def test_some_of_the_copies_go_on_after_resets_and_restored_states_as_each_does_alone(backend, read):
    scene = Scene((read(HANGING + joint("revolute", axis("0 1 0")) + SERVO),))
    n, random, options = len(SEEDS), np.random.default_rng(8), backend.options()
    with ExitStack() as opened:
        copies = opened.enter_context(
            backend.open_batch(scene, seeds=SEEDS, options=options, threads=1)
        ).worlds
        runs = [opened.enter_context(backend.open(scene, seed=seed, options=options)) for seed in SEEDS]
        saved = [([], []) for _ in SEEDS]
        for _ in range(80):
            for number in random.permutation(n)[: random.integers(3)]:
                choice, value = (
                    random.choice(["reset", "save", "restore", "gains", "gains"]),
                    random.uniform(0, 4),
                )
                for each, kept in zip((copies[number], runs[number]), saved[number], strict=True):
                    act(each, choice, value, kept)
            chosen = (
                random.permutation(n)[: random.choice([1, 2, n])] if random.random() < 0.5 else np.arange(n)
            )
            going = [copies[number] for number in chosen]
            assert advance_together(going, [world.now_ns + STEP_NS for world in going]) == {}
            for number in chosen:
                runs[number].run_until(runs[number].now_ns + STEP_NS)
            for copied, alone in zip(copies, runs, strict=True):
                assert copied.snapshot().payload == alone.snapshot().payload
        wrenches = [[world.engine.joint_wrench("robot", "j") for world in each] for each in (copies, runs)]
        assert wrenches[0] == wrenches[1]


@pytest.mark.parametrize("reads_before", [False, True])
@pytest.mark.parametrize("reads_after", [False, True])
def test_forces_of_the_last_step_are_those_alone_after_a_model_was_moved(
    backend, read, reads_before, reads_after
):
    scene = Scene((read(HANGING + joint("revolute", axis("0 1 0"))),))

    def felt(world):
        world.set_joints("robot", {"j": 0.4})
        world.run_until(2 * STEP_NS)
        for is_read, position in ((reads_before, 0.8), (reads_after, 1.2)):
            if is_read:
                world.link_motion("robot", scene.model("robot").links[-1].name)
            world.set_joints("robot", {"j": position})
        return world.engine.joint_wrench("robot", "j")

    with backend.open_batch(scene, seeds=SEEDS[:2], options=backend.options(), threads=0) as batch:
        copied = felt(batch.worlds[1])
    with backend.open(scene, seed=SEEDS[1], options=backend.options()) as alone:
        assert felt(alone) == copied


def test_a_copy_that_is_reset_alone_begins_anew_and_the_others_go_on(backend, scene, batch):
    publication = batch.advertise("/husky/cmd_vel")
    publication.publish(commands(0))
    batch.run_until(5 * STEP_NS)
    batch.reset_copy(1, seed=7)
    assert [world.now_ns for world in batch.worlds] == [5 * STEP_NS, 0, *[5 * STEP_NS] * 3]
    batch.run_until(8 * STEP_NS)
    assert batch.now_ns == 8 * STEP_NS
    assert [world.now_ns for world in batch.worlds] == [8 * STEP_NS, 3 * STEP_NS, *[8 * STEP_NS] * 3]
    with backend.open(scene, seed=7, options=backend.options()) as alone:
        alone.run_until(3 * STEP_NS)
        motion = alone.model_motion("husky")
        assert (*motion.pose.position, *motion.pose.orientation) == tuple(
            batch.motions("husky")[1, :7].tolist()
        )
    batch.reset()
    assert [world.now_ns for world in batch.worlds] == [0] * len(SEEDS)
    batch.run_until(STEP_NS)
    assert [world.now_ns for world in batch.worlds] == [STEP_NS] * len(SEEDS)


def test_the_number_of_threads_changes_nothing(backend, scene):
    ends = []
    for threads in (1, 3):
        with backend.open_batch(scene, seeds=SEEDS, options=backend.options(), threads=threads) as batch:
            drive(batch)
            ends.append(batch.motions("husky"))
    assert (ends[0] == ends[1]).all()
    assert len(np.unique(ends[0], axis=0)) == len(SEEDS)  # the copies went different ways


def test_a_reset_batch_does_the_same_again(batch):
    drive(batch)
    first = batch.motions("husky")
    batch.reset()
    assert batch.now_ns == 0
    drive(batch)
    assert (batch.motions("husky") == first).all()


def test_new_seeds_come_with_a_reset(batch):
    batch.reset(seeds=range(len(SEEDS)))
    assert [world.seed for world in batch.worlds] == list(range(len(SEEDS)))


def test_a_copy_that_diverges_stops_and_the_others_go_on(batch):
    batch.worlds[1].place("husky", ModelMotion(Pose((0.0, 0.0, 1.0)), linear=(1e200, 0.0, 0.0)))
    drive(batch)
    assert set(batch.failures) == {1}
    assert isinstance(batch.failures[1], DivergedError)
    assert [world.now_ns for number, world in enumerate(batch.worlds) if number != 1] == [batch.now_ns] * 4
    batch.reset()
    drive(batch)
    assert not batch.failures


def test_when_all_copies_have_failed_that_is_an_error(batch):
    for world in batch.worlds:
        world.place("husky", ModelMotion(Pose((0.0, 0.0, 1.0)), linear=(1e200, 0.0, 0.0)))
    with pytest.raises(DivergedError):
        batch.run_until(STEP_NS)


def test_a_mistake_of_the_caller_does_not_break_the_copies(batch, golden: Golden):
    batch.run_until(STEP_NS)
    with golden.raises(LifecycleError):
        batch.run_until(0)
    assert not batch.failures
    batch.run_until(2 * STEP_NS)


def broken(*_):
    raise ZeroDivisionError("broken")


def test_a_world_whose_part_breaks_on_numbers_has_failed(batch, monkeypatch, golden: Golden):
    publication = batch.advertise("/husky/cmd_vel")
    with golden.raises(TopicError):
        publication.publish(np.full((len(SEEDS), 6), np.nan))
    assert {world.state for world in batch.worlds} == {State.READY}
    monkeypatch.setattr(batch.worlds[0].engine, "set_drive", broken)
    with golden.raises(SimulationError, match="/husky/cmd_vel"):
        publication.publish(commands(0))
    assert [world.state is State.FAILED for world in batch.worlds] == [True, *[False] * 4]
    monkeypatch.undo()
    batch.reset()
    drive(batch)
    assert not batch.failures


def test_a_copy_whose_drive_breaks_fails_alone_in_a_command_that_all_take_at_once(
    backend, scene, batch, monkeypatch
):
    engine = type(batch.worlds[1].engine)
    monkeypatch.setattr(engine, "set_drive_of", classmethod(broken))
    monkeypatch.setattr(batch.worlds[1].engine, "set_drive", broken)
    publications = [world.advertise("/husky/cmd_vel") for world in batch.worlds]
    for world, publication, row in zip(batch.worlds, publications, commands(0).tolist(), strict=True):
        world.hold_messages()
        publication.publish_numbers(row)
    assert [*release_together(batch.worlds)] == [1]
    assert [world.state is State.FAILED for world in batch.worlds] == [False, True, *[False] * 3]
    batch.run_until(5 * STEP_NS)
    assert [*batch.failures] == [1]
    monkeypatch.undo()
    with backend.open(scene, seed=SEEDS[2], options=backend.options()) as alone:
        alone.advertise("/husky/cmd_vel").publish_numbers(commands(0)[2].tolist())
        alone.run_until(5 * STEP_NS)
        assert alone.snapshot().payload == batch.worlds[2].snapshot().payload


@pytest.mark.parametrize(
    ("rows", "why"),
    [((2, 6), ""), ((5, 3), "needs 6 numbers"), ((5,), "needs 6 numbers")],
)
def test_commands_that_do_not_fit_are_refused(batch, rows, why, golden: Golden):
    with golden.raises(TopicError, match=why):
        batch.advertise("/husky/cmd_vel").publish(np.zeros(rows))


def test_an_array_is_not_a_message_where_text_is_expected(batch, golden: Golden):
    publication = batch.advertise("/gazebo/set_model_state")
    with golden.raises(TopicError):
        publication.publish(np.zeros((5, 13)))


def test_a_batch_needs_a_seed(backend, scene, golden: Golden):
    with golden.raises(ValueError):
        backend.open_batch(scene, seeds=(), options=backend.options())
