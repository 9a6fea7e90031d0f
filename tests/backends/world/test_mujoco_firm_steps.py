"""How MuJoCo takes its steps with firm joints."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import replace
from math import sin
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from chains import LINKS, chain, command
from golden import Golden
from jointed import HANGING, axis, joint, link, read, told
from nrp_world_mujoco.firm_steps import address_at, call, integer_at, number_at, put_number

from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit
from nrp_core.errors import SceneError, SimulationError
from nrp_core.messages.geometry_msgs import Quaternion
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.rigid import rotation_by
from nrp_core.scene.sdf import read_model
from nrp_core.world.backends import worlds
from nrp_core.world.robot_setup import JointControl, RobotSetup, set_up_robot
from nrp_core.world.world import World

pytest.importorskip("nrp_world_mujoco")
from nrp_world_mujoco import build as building
from nrp_world_mujoco import firm_steps
from nrp_world_mujoco.firm_steps import ARRAYS, Constraints
from nrp_world_mujoco.library import structures


def opened(model: Model | None = None) -> World:
    backend = worlds().load("mujoco")
    return backend.open(Scene((model or chain(),)), seed=1, options=backend.options())


@jit
def reached(numbers: int, count: int, holder: int, function: int) -> tuple[float, int, int]:
    """Return what is at addresses, write a number, and call a function."""
    found = number_at(numbers + 8), integer_at(count), address_at(holder)
    put_number(numbers, 4.0)
    call(function, numbers, 5)
    return found


def test_numbers_and_functions_are_reached_by_their_addresses() -> None:
    numbers, count = np.array([1.5, -2.5]), np.array([-7], dtype=np.int32)
    start, seen = numbers.ctypes.data, []
    holder = ctypes.c_void_p(start)
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(lambda a, b: seen.append((a, b)))
    code = ctypes.cast(function, ctypes.c_void_p).value or 0
    assert reached(start, count.ctypes.data, ctypes.addressof(holder), code) == (-2.5, -7, start)
    assert numbers.tolist() == [4.0, -2.5]
    assert seen == [(start, 5)]


@jit
def places(state: IntArray) -> tuple[int, int, list[int]]:
    """Return the numbers and addresses that compiled code finds."""
    return integer_at(state[0]), integer_at(state[1]), [address_at(each) for each in state[2:]]


def led(model: Model) -> Model:
    return set_up_robot(model, RobotSetup(control=((".*", JointControl("position")),)))


def option(flag: str) -> str:
    return f'<mujoco:option xmlns:mujoco="urn:mujoco"><mujoco:flag {flag}/></mujoco:option>'


def swing(world: World, steps: range) -> list[list[float]]:
    """Command all joints in each step, and return their positions."""
    rows = []
    for step in steps:
        for number in range(LINKS):
            command(world, 0.2 * sin(0.1 * step + number), joint=f"j{number}")
        world.run_until(step * 20_000_000)
        rows.append(world.joint_states("chain").positions.tolist())
    return rows


def test_the_constraints_of_a_step_are_found_in_the_state() -> None:
    with opened() as world:
        swing(world, range(1, 2))
        data: Any = world.engine._data  # type: ignore[attr-defined]
        found = Constraints(data)
        assert found.direct
        arrays = [getattr(data, name).ctypes.data for name in ARRAYS]
        memory = [data.maxuse_arena, data.narena]
        assert places(found.addresses) == (data.ne, data.nf, [*arrays, *memory])
        assert (data.ne, data.nf) == (0, LINKS)


def undescribed() -> dict[str, Any]:
    raise ImportError


def shifted() -> dict[str, Any]:
    """Return MuJoCo's descriptions with the constraints two places too early, as of another version."""
    described = dict(structures())
    fields = [field for field in described["mjData"].fields if field.name not in ("efc_margin", "efc_vel")]
    return described | {"mjData": SimpleNamespace(fields=fields)}


@pytest.mark.parametrize("described", [undescribed, shifted])
def test_steps_are_the_same_where_the_layout_of_the_state_is_unknown(
    described: Callable[[], dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    with opened() as world:
        expected = swing(world, range(1, 11))
    monkeypatch.setattr(firm_steps, "structures", described)
    monkeypatch.setattr(firm_steps, "layout", firm_steps.layout.__wrapped__)
    with opened() as world:
        assert swing(world, range(1, 11)) == expected
        assert not world.engine._control.firm._constraints.direct  # type: ignore[attr-defined]
        told = ["is not laid out as its package says" in each.message for each in world.warnings]
        assert told == ([True] if described is shifted else [])


def test_the_constraint_of_a_joint_is_found_wherever_it_stands() -> None:
    """Constraints of bodies that sleep are left out, so those of others stand elsewhere."""
    with opened() as world:
        expected = swing(world, range(1, 11))
    with opened() as world:
        rows = world.engine._control.firm._joints["row"]  # type: ignore[attr-defined]
        positions = []
        for step in range(1, 11):
            rows[:] = [5, 4, 1, 99, 0, 0]
            positions += swing(world, range(step, step + 1))
        assert positions == expected
        assert rows.tolist() == list(range(LINKS))


def test_the_constraint_of_a_tendon_is_not_that_of_the_joint_with_its_number(tmp_path: Path) -> None:
    """After j0 is released, that of the tendon 1 stands where that of the degree of freedom 1 stood."""
    cords = "".join(
        f'<mujoco:fixed name="t{n}" frictionloss="{n}"><mujoco:joint joint="j0" coef="1"/></mujoco:fixed>'
        for n in (0, 1)
    )
    file = link("bob") + f'<mujoco:tendon xmlns:mujoco="urn:mujoco">{cords}</mujoco:tendon>'
    free = JointController("j0", "effort", "/chain/j0/effort")
    arm = chain(links=2)
    arm = replace(arm, controllers=(*arm.controllers, free), native=read(tmp_path, file).native)
    with opened(arm) as world:
        for number in range(2):
            command(world, 0.1, joint=f"j{number}")
        world.run_until(100_000_000)
        command(world, 0.0, kind="effort")
        command(world, 0.3, joint="j1")
        world.run_until(600_000_000)
        assert world.joint_states("chain").positions[1] == pytest.approx(0.3, abs=1e-3)


def test_the_solver_begins_with_the_motion_that_is_wanted_and_ends_after_one_iteration() -> None:
    iterations = []
    with opened() as world:
        for step in range(1, 60):
            swing(world, range(step, step + 1))
            iterations.append(int(world.engine._data.solver_niter.max()))  # type: ignore[attr-defined]
    assert np.mean(iterations[5:]) <= 1.0


def islands(world: World) -> int:
    """Return into how many separate sets MuJoCo divided the constraints of the last step."""
    return int(world.engine._data.nisland)  # type: ignore[attr-defined]


def test_constraints_of_few_joints_are_solved_at_once_to_the_same_motion(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with opened() as world:
        at_once, none = swing(world, range(1, 30)), islands(world)
    monkeypatch.setattr(building, "FEW_FREEDOMS", LINKS - 1)
    with opened() as world:
        assert at_once == pytest.approx(np.array(swing(world, range(1, 30))), abs=1e-9)
        assert (none, islands(world)) == (0, 1)


def test_a_lack_of_memory_is_an_error_and_does_not_end_the_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def small(spec: Any) -> Any:
        spec.memory = 1250
        return spec.compile()

    monkeypatch.setattr(building, "compile_spec", small)
    with opened() as world:
        command(world, 0.1)
        with pytest.raises(SimulationError, match="mj_stackAlloc"):
            world.run_until(20_000_000)


def test_a_joint_moves_where_a_file_takes_dry_friction_away(tmp_path: Path) -> None:
    """Firm joints are dry friction in MuJoCo, so gains move them then."""
    file = tmp_path / "arm.urdf"
    file.write_text(
        """<robot name="arm"><link name="world"/><link name="l"><inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="j" type="continuous"><parent link="world"/><child link="l"/></joint>
        <mujoco><option><flag frictionloss="disable"/></option></mujoco></robot>"""
    )
    model = led(read_model(file, name="arm"))
    with opened(model) as world:
        world.advertise(model.controllers[0].topic).publish(Float64(0.3))
        world.run_until(1_000_000_000)
        assert world.joint_states("arm").positions == pytest.approx([0.3], abs=1e-3)


def test_a_ball_joint_that_takes_orientations_is_refused_where_a_file_takes_dry_friction_away(
    tmp_path: Path,
    golden: Golden,
) -> None:
    """A ball joint has no gains."""
    model = read(tmp_path, HANGING + joint("ball") + option('frictionloss="disable"'))
    with golden.raises(SceneError, match="robot.sdf:1.*'j'.*'robot'"):
        opened(led(model))


def test_a_ball_joint_moves_after_a_rest_where_bodies_at_rest_sleep(tmp_path: Path) -> None:
    damped = axis("0 0 1", "<dynamics><damping>1</damping></dynamics>")
    model = led(read(tmp_path, HANGING + joint("ball", damped) + option('sleep="enable"')))
    with opened(model) as world:
        world.run_until(2_000_000_000)
        world.advertise("/robot/j/cmd_pos").publish(Quaternion(*rotation_by((0.0, 0.8, 0.0))))
        world.run_until(3_000_000_000)
        assert told(world)[0] == pytest.approx({"j_x": 0.0, "j_y": 0.8, "j_z": 0.0}, abs=1e-3)
        assert islands(world) == 1, "bodies sleep by islands"
