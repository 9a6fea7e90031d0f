"""Scenes of few shapes test each pair: faster than MuJoCo's bounding volumes, and the same contacts."""

from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.world.backends import worlds

pytest.importorskip("nrp_world_mujoco")
from nrp_world_mujoco import build as building
from nrp_world_mujoco.library import mujoco

ROOM = Path(str(files("nrp_experiments.braitenberg_husky")))


def positions_at_the_wall(**settings: Any) -> tuple[bool, list[bytes]]:
    """Drive the Husky into the wall; return whether all pairs were tested, and the states on the way."""
    robot = read_model(ROOM / "husky.sdf", name="husky", pose=Pose.from_rpy((5.5, 0, 0.15), 0, 0, 0.4))
    scene, backend = read_scene(ROOM / "room.sdf").with_model(robot), worlds().load("mujoco")
    with backend.open(scene, seed=1, options=backend.options(**settings)) as world:
        command = world.advertise("/husky/cmd_vel")
        message = command.topic.type()
        message.linear.x = 1.0
        command.publish(message)
        engine, states = world.engine, []
        for step in range(1, 100):
            world.run_until(step * 20_000_000)
            states.append(engine._data.qpos.tobytes() + engine._data.contact.geom.tobytes())  # type: ignore[attr-defined]
        off = engine._model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_MIDPHASE  # type: ignore[attr-defined]
        return bool(off), states


def test_every_contact_and_position_is_that_of_bounding_volumes(monkeypatch: pytest.MonkeyPatch) -> None:
    pairs, found = positions_at_the_wall()
    monkeypatch.setattr(building, "FEW_GEOMS", 0)
    volumes, expected = positions_at_the_wall()
    assert (pairs, volumes) == (True, False)
    assert found == expected
    assert max(map(len, expected)) > len(expected[0]), "the wall is touched"


def test_a_wrong_way_to_test_fewer_pairs_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    _, expected = positions_at_the_wall()
    fewer = mujoco.mjtDisableBit.mjDSBL_MIDPHASE | mujoco.mjtDisableBit.mjDSBL_MULTICCD
    monkeypatch.setattr(building, "SAME_CONTACTS", fewer)
    _, found = positions_at_the_wall()
    assert found != expected
