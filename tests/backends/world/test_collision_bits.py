"""Which shapes collide follows from their bits (``contype``, ``collide_bitmask``) as in MuJoCo alone."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from pathlib import Path
from random import Random

import mujoco
import pytest

from nrp_core import World, worlds
from nrp_core.scene.sdf import read_scene

BODIES, SHAPES = 7, 2
FEW = (0, 1, 2, 4, 8, 12)
Bits = list[tuple[int, int]]
"""Category and what is touched, of each shape."""


def bits_of(random: Random) -> list[Bits]:
    """Return random bits of the shapes of each body."""
    return [[(random.choice(FEW), random.choice(FEW)) for _ in range(SHAPES)] for _ in range(BODIES)]


def as_mjcf(bodies: list[Bits]) -> str:
    texts = []
    for number, shapes in enumerate(bodies):
        geoms = "".join(f'<geom name="g{number}_{n}" size="0.1" pos="0 0 {0.01 * n + 0.03 * number}" '
                        f'contype="{one}" conaffinity="{other}"/>'
                        for n, (one, other) in enumerate(shapes))  # fmt: skip
        texts.append(f'<body name="b{number}"><freejoint/>{geoms}</body>')
    return f"<mujoco><worldbody>{''.join(texts)}</worldbody></mujoco>"


def as_sdf(bodies: list[Bits]) -> str:
    texts = []
    for number, shapes in enumerate(bodies):
        collisions = "".join(
            f'<collision name="g{number}_{n}"><pose>0 0 {0.01 * n + 0.03 * number} 0 0 0</pose>'
            "<geometry><sphere><radius>0.1</radius></sphere></geometry><surface><contact>"
            f"<collide_bitmask>{other}</collide_bitmask><category_bitmask>{one}</category_bitmask>"
            "</contact></surface></collision>" for n, (one, other) in enumerate(shapes))  # fmt: skip
        link = f'<link name="b{number}"><inertial auto="true"/>{collisions}</link>'
        texts.append(f'<model name="b{number}">{link}</model>')
    return f'<sdf version="1.11"><world name="w">{"".join(texts)}</world></sdf>'


def alone(bodies: list[Bits]) -> set[frozenset[str]]:
    """Return the pairs of bodies that touch in MuJoCo alone."""
    model = mujoco.MjModel.from_xml_string(as_mjcf(bodies))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return {frozenset(model.body(model.geom_bodyid[n]).name for n in each.geom) for each in data.contact}


def touching(world: World) -> set[frozenset[str]]:
    """Return the pairs of models that touch after a step."""
    world.run_until(2_000_000)
    engine = world.engine
    if hasattr(engine, "_data"):
        owners = engine._built.owners
        pairs = [[owners[n][0] for n in each.geom] for each in engine._data.contact]
    else:
        bullet = pytest.importorskip("pybullet")
        owners = engine._built.owners
        found = bullet.getContactPoints(physicsClientId=engine._client)
        pairs = [[owners[each[1], each[3]][0], owners[each[2], each[4]][0]] for each in found]
    return set(map(frozenset, pairs))


@pytest.mark.parametrize(("form", "write"), [("xml", as_mjcf), ("sdf", as_sdf)])
@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
@pytest.mark.parametrize("seed", range(3))
def test_the_bodies_touch_that_touch_in_mujoco_alone(tmp_path: Path, form, write, engine, seed):
    bodies = bits_of(Random(seed))
    (tmp_path / f"bodies.{form}").write_text(write(bodies))
    wanted = alone(bodies)
    assert 0 < len(wanted) < len(list(combinations(bodies, 2)))
    backend = worlds().load(engine)
    options = backend.options.model_validate({"timestep": "2 ms"})
    with backend.open(read_scene(tmp_path / f"bodies.{form}"), seed=1, options=options) as world:
        assert not world.warnings
        assert touching(world) == wanted


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
@pytest.mark.parametrize(("bits", "touches"), [((4, 4), True), ((0, 8), True), ((0, 0), False)])
def test_mjcf_without_bits_touches_every_shape_of_another_file_that_has_some(
    tmp_path: Path, engine, bits, touches
):
    """As a shape of SDF without bits, which has 0xFFFF in sdformat."""
    (tmp_path / "ball.xml").write_text(as_mjcf([[(1, 1)]]))
    (tmp_path / "room.sdf").write_text(as_sdf([[bits]]).replace("b0", "room"))
    scenes = [read_scene(tmp_path / name) for name in ("ball.xml", "room.sdf")]
    scene = replace(scenes[1], models=tuple(model for each in scenes for model in each.models))
    backend = worlds().load(engine)
    options = backend.options.model_validate({"timestep": "2 ms"})
    with backend.open(scene, seed=1, options=options) as world:
        assert bool(touching(world)) == touches
