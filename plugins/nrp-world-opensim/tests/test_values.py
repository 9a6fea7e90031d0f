"""What the platform computes is what OpenSim computes alone, to the bit."""

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import opensim as osim
import pytest
from nrp_core.world import Engine, FloatArray

from conftest import Open
from nrp_world_opensim.reader import ALL
from own_models import MODELS

STEP_S, STEPS = 0.01, 40
File = Callable[[str], Path]
MUSCLES = {"arm": ("flexor", "extensor")}
MOTORS = {"knee": ("hip_motor",)}


def excitations(step: int, number: int) -> FloatArray:
    return np.random.default_rng(step).uniform(0.02, 0.8, number)


def drive(engine: Engine, name: str, step: int) -> None:
    """Set the excitations of a step."""
    muscles, motors = MUSCLES.get(name, ()), MOTORS.get(name, ())
    values = excitations(step, len(muscles) + len(motors))
    if muscles:
        engine.set_controls(name, muscles, values[: len(muscles)])
    for motor, value in zip(motors, values[len(muscles) :].tolist(), strict=True):
        engine.set_control(name, motor, value)


def observed(engine: Engine, name: str) -> FloatArray:
    joints = engine.joint_states(name)
    muscles = engine.actuator_states(name, MUSCLES[name]).ravel() if name in MUSCLES else ()
    return np.concatenate([joints.positions, joints.velocities, muscles])


def run(engine: Engine, name: str, steps: range) -> list[FloatArray]:
    found = []
    for step in steps:
        drive(engine, name, step)
        engine.advance(1)
        found.append(observed(engine, name))
    return found


def alone(path: Path, name: str) -> list[FloatArray]:
    """Return the same from OpenSim, with a controller in the model that sets the excitations."""
    names = (*MUSCLES.get(name, ()), *MOTORS.get(name, ()))
    model = osim.Model(str(path))
    model.initSystem()
    controller = osim.PrescribedController()
    for each in names:
        controller.addActuator(model.getActuators().get(each))
        controller.prescribeControlForActuator(each, osim.Constant(0.0))
    if names:
        model.addController(controller)
    state = model.initSystem()
    model.equilibrateMuscles(state)
    manager = osim.Manager(model)
    manager.setIntegratorAccuracy(1e-4)
    functions = controller.get_ControlFunctions()
    constants = [osim.Constant.safeDownCast(functions.get(index)) for index in range(len(names))]
    muscles = [model.getMuscles().get(each) for each in MUSCLES.get(name, ())]
    coordinates = [model.getCoordinateSet().get(index) for index in range(model.getNumCoordinates())]
    found = []
    for step in range(STEPS):
        for constant, value in zip(constants, excitations(step, len(names)).tolist(), strict=True):
            constant.setValue(value)
        manager.initialize(state)
        state = manager.integrate((step + 1) * 10_000_000 / 1e9)
        model.realizeDynamics(state)
        reads: list[Any] = [each.getValue for each in coordinates]
        reads += [each.getSpeedValue for each in coordinates]
        for kind in ("getFiberLength", "getFiberVelocity", "getTendonForce", "getActivation"):
            reads += [getattr(muscle, kind) for muscle in muscles]
        found.append(np.array([read(state) for read in reads]))
    return found


@pytest.mark.parametrize("name", MODELS)
def test_coordinates_and_muscles_are_those_of_opensim(name: str, file_of: File, open_world: Open) -> None:
    path = file_of(name)
    engine = open_world(path, timestep="10 ms").engine
    ours, theirs = run(engine, name, range(STEPS)), alone(path, name)
    assert len(theirs[0]) == len(ours[0])
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-10)
    assert np.ptp(ours, axis=0).max() > 0.1  # it moved


@pytest.mark.parametrize("name", MODELS)
def test_a_snapshot_continues_to_the_bit_in_another_engine(
    name: str, file_of: File, open_world: Open
) -> None:
    path = file_of(name)
    first, second = (open_world(path, timestep="10 ms").engine for _ in range(2))
    run(first, name, range(7))
    saved = pickle.dumps(first.save())
    expected = run(first, name, range(7, 20))
    run(second, name, range(3, 9))
    second.restore(pickle.loads(saved))
    np.testing.assert_array_equal(run(second, name, range(7, 20)), expected)


@pytest.mark.parametrize("name", MODELS)
def test_a_reset_repeats_the_run_to_the_bit(name: str, file_of: File, open_world: Open) -> None:
    engine = open_world(file_of(name), timestep="10 ms").engine
    start = observed(engine, name)
    expected = run(engine, name, range(12))
    engine.reset(1)
    np.testing.assert_array_equal(observed(engine, name), start)
    np.testing.assert_array_equal(run(engine, name, range(12)), expected)


def test_reading_a_state_does_not_change_the_future(file_of: File, open_world: Open) -> None:
    path = file_of("arm")
    seen, unseen = (open_world(path, timestep="10 ms").engine for _ in range(2))
    expected = run(seen, "arm", range(12))
    for step in range(12):
        drive(unseen, "arm", step)
        unseen.advance(1)
    np.testing.assert_array_equal(observed(unseen, "arm"), expected[-1])


def test_steps_at_once_are_the_steps_one_by_one(file_of: File, open_world: Open) -> None:
    path = file_of("ball")
    first, second = (open_world(path).engine for _ in range(2))
    first.advance(30)
    for _ in range(30):
        second.advance(1)
    np.testing.assert_array_equal(observed(first, "ball"), observed(second, "ball"))


def test_one_message_commands_a_group(file_of: File, open_world: Open) -> None:
    from nrp_core.messages.std_msgs import Float64MultiArray

    world = open_world(file_of("arm"))
    world.advertise(f"/arm/{ALL}/cmd").publish(Float64MultiArray(data=np.array([1.0, 0.0])))
    world.run_until(40_000_000)
    flexor, extensor = world.engine.actuator_states("arm", ("flexor", "extensor"))[3].tolist()
    assert flexor > 0.5 > 0.1 > extensor
