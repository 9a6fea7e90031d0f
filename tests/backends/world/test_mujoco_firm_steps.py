"""How MuJoCo takes its steps with firm joints."""

from __future__ import annotations

import ctypes
from math import sin
from typing import Any

import numpy as np
import pytest
from chains import LINKS, chain, command

from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit
from nrp_core._support.memory import address_at, call, integer_at, number_at, put_number
from nrp_core.errors import SimulationError
from nrp_core.world.backends import worlds
from nrp_core.world.scene.model import Scene
from nrp_core.world.world import World

pytest.importorskip("nrp_world_mujoco")
from nrp_world_mujoco import build as building
from nrp_world_mujoco.state_layout import addresses


def opened(links: int = LINKS) -> World:
    backend = worlds().load("mujoco")
    return backend.open(Scene((chain(links=links),)), seed=1, options=backend.options())


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
def places(layout: IntArray) -> tuple[int, int, int, int, int]:
    """Return the numbers and addresses that a layout leads to."""
    counts = integer_at(layout[0]), integer_at(layout[1])
    return *counts, address_at(layout[2]), address_at(layout[3]), address_at(layout[4])


def test_the_constraints_of_a_step_are_found_in_the_state() -> None:
    with opened() as world:
        for number in range(LINKS):
            command(world, 0.1, joint=f"j{number}")
        world.run_until(20_000_000)
        data: Any = world.engine._data  # type: ignore[attr-defined]
        arrays = data.efc_KBIP, data.efc_aref, data.efc_force
        assert places(addresses(data)) == (data.ne, data.nf, *(array.ctypes.data for array in arrays))
        assert (data.ne, data.nf) == (0, LINKS)


def test_the_solver_begins_with_the_motion_that_is_wanted_and_ends_after_one_iteration() -> None:
    iterations = []
    with opened() as world:
        for step in range(1, 60):
            for number in range(LINKS):
                command(world, 0.2 * sin(0.1 * step + number), joint=f"j{number}")
            world.run_until(step * 20_000_000)
            iterations.append(int(world.engine._data.solver_niter.max()))  # type: ignore[attr-defined]
    assert np.mean(iterations[5:]) <= 1.0


def test_a_lack_of_memory_is_an_error_and_does_not_end_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    def small(spec: Any) -> Any:
        spec.memory = 1500
        return spec.compile()

    monkeypatch.setattr(building, "compiled", small)
    with opened() as world:
        command(world, 0.1)
        with pytest.raises(SimulationError, match="mj_stackAlloc: out of memory"):
            world.run_until(20_000_000)
