"""Random attributes by MuJoCo's own schema act as in MuJoCo alone, or a warning names them."""

from __future__ import annotations

from pathlib import Path
from random import Random

import mujoco
import numpy as np
import pytest
from nrp_world_mujoco.schema import attributes_of

from nrp_core import worlds
from nrp_core.scene.sdf import read_scene

BASE = """<mujoco><compiler angle="radian"/>
  <option gravity="0.5 0 -9.81" {option}><flag {flag}/></option>
  <default><default class="of"><joint {joint}/><tendon {tendon}/><general {general}/><geom {geom}/>
    <equality {equality}/></default></default>
  <worldbody><site name="anchor" pos="-0.1 0 1.3"/>
    <geom name="floor" type="plane" size="2 2 1" pos="0 0 0.65"/>
    <body name="arm" pos="0 0 1"><joint name="shoulder" axis="0 1 0" class="of"/>
      <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="0.3" contype="0" conaffinity="0"/>
      <site name="end" pos="0.15 0 0.02"/>
      <body name="hand" pos="0.3 0 0"><joint name="wrist" axis="0 1 0" class="of"/>
        <geom name="tip" type="sphere" size="0.05" pos="0.1 0 0" mass="0.1" class="of"/></body></body>
    <body name="other" pos="0 1 1.5"><joint name="free" axis="0 1 0" damping="0.1"/>
      <geom size="0.05" pos="0.1 0 0" mass="0.2" contype="0" conaffinity="0"/></body></worldbody>
  {contact}<equality><joint joint1="free" joint2="wrist" class="of" polycoef="0 0.5 0 0 0"/></equality>
  <tendon><spatial name="cord" class="of"><site site="anchor"/><site site="end"/></spatial></tendon>
  <actuator><general name="pull" tendon="cord" class="of"/>
    <muscle name="flex" tendon="cord" lengthrange="0.1 0.6" force="5"/></actuator></mujoco>"""
NUMBERS = {
    "biastype": ("affine",), "conaffinity": ("1", "3"), "condim": ("1", "3", "4", "6"),
    "contype": ("1", "3"), "delay": ('0.02" nsample="16',), "dyntype": ("filter", "integrator", "none"),
    "gaintype": ("fixed", "affine"), "limited": ('true" range="-0.4 0.4',), "priority": ("1", "2"),
    "range": ("-0.5 0.6", "0.05 0.5"), "solimp": ("0.8 0.9 0.01 0.5 2",), "solref": ("0.03 0.8", "-400 -20"),
    "cone": ("pyramidal", "elliptic"), "integrator": ("Euler", "RK4", "implicit"),
    "timestep": ("0.001", "0.0025"),
    "jacobian": ("dense", "sparse"), "solver": ("CG", "PGS"), "iterations": ("50",), "tolerance": ("1e-10",),
    "actuatorgroupdisable": ("1", "3"), "ccd_iterations": ("20",), "sdf_initpoints": ("20",),
    "o_friction": ("0.3 0.3 0.01 0.001 0.001",),
    "o_solimp": ("0.8 0.9 0.01 0.5 2",), "o_solref": ("0.03 0.8",),
    "springdamper": ("0.3 0.8",), "interp": ("zoh", "linear"), "wind": ("1 0.3 0",), "magnetic": ("0 1 0",),
    "noslip_iterations": ("3",), "ls_iterations": ("40",), "sdf_iterations": ("12",),
    "actuatorfrclimited": ('true" actuatorfrcrange="-0.5 0.4',), "actuatorgravcomp": ("true",),
    "actdim": ('1" dyntype="filter',), "actearly": ('true" dyntype="filter',),
    "actlimited": ('true" dyntype="integrator" actrange="-0.1 0.05',),
    "actrange": ('-0.1 0.05" dyntype="integrator',), "ctrllimited": ('true" ctrlrange="-0.5 0.4', "false"),
    "ctrlrange": ("-0.4 0.3",),
    "forcelimited": ('true" forcerange="-0.2 0.3',), "input": ("pos", "vel"), "nsample": ("8",),
    "fluidshape": ("ellipsoid",), "shellinertia": ("false",), "active": ("true", "false"),
}  # fmt: skip
"""Values of attributes that are not any numbers; solref and solimp have several names."""
PLACED = {"axis", "fromto", "gravity", "group", "hfield", "mass", "material", "mesh",
          "pos", "quat", "axisangle", "euler", "xyaxes", "zaxis", "rgba", "type", "user", "width",
          "castshadow", "class", "name", "inheritrange"}  # fmt: skip
"""Attributes that are another subject: places, looks, and what the experiment sets."""
ENABLED = {name.removeprefix("mjENBL_").lower() for name in mujoco.mjtEnableBit.__members__}
FLAGS = (*mujoco.mjtDisableBit.__members__, *mujoco.mjtEnableBit.__members__)


def value(element: str, attribute: str, random: Random) -> str:
    if element == "flag":
        return "enable" if attribute in ENABLED else "disable"
    kind = next((each for each in ("solimp", "solref") if attribute.startswith(each)), attribute)
    if kind in NUMBERS:
        return random.choice(NUMBERS[kind])
    numbers = {"range": (-random.uniform(0.5, 2), random.uniform(0.5, 2))}
    given = next(
        (each for end, each in numbers.items() if attribute.endswith(end)), (random.uniform(0.01, 0.4),)
    )
    return " ".join(map(repr, given))


def attributes(element: str) -> list[str]:
    if element == "flag":
        names = (each.partition("_")[2].lower() for each in FLAGS if not each.startswith("mjN"))
        return [name for name in names if name != "ipc"]  # which needs another integrator
    return [name for name in attributes_of(element) if name not in PLACED]


def model_of(chosen: dict[str, dict[str, str]]) -> str:
    texts = {kind: " ".join(f'{name}="{each}"' for name, each in chosen.get(kind, {}).items())
             for kind in KINDS}  # fmt: skip
    pair = (
        f'<contact><pair geom1="tip" geom2="floor" {texts.pop("pair")}/></contact>'
        if "pair" in chosen
        else ""
    )
    return BASE.format(contact=pair, **{"pair": "", **texts})


def difference(text: str, folder: Path) -> tuple[float, str]:
    """Return the largest difference of a joint within 0.3 s, and the warnings.

    Raises:
        ValueError: MuJoCo refuses the model.
    """
    theirs = mujoco.MjModel.from_xml_string(text)
    (folder / "arm.xml").write_text(text)
    backend = worlds().load("mujoco")
    with backend.open(read_scene(folder / "arm.xml"), seed=1, options=backend.options()) as world:
        ours, here = world.engine._model, mujoco.MjData(world.engine._model)
        there = mujoco.MjData(theirs)
        for name in ("pull", "flex"):
            number = ours.actuator(f"arm/{name}/actuator").id
            here.ctrl[ours.actuator_ctrladr[number]] = there.ctrl[theirs.actuator(name).id] = 0.7
        pairs = [(theirs.joint(n).qposadr[0], ours.joint(f"{m}/{n}").qposadr[0])
                 for n, m in (("shoulder", "arm"), ("wrist", "arm"), ("free", "other"))]  # fmt: skip
        worst = 0.0
        for _ in range(round(0.3 / theirs.opt.timestep)):
            mujoco.mj_step(theirs, there)
            mujoco.mj_step(ours, here)
            moved = [there.qpos[one] - theirs.qpos0[one] - here.qpos[other] for one, other in pairs]
            worst = max(worst, float(np.abs(moved).max()))
        return worst, " ".join(each.message for each in world.warnings)


KINDS = ("option", "flag", "joint", "tendon", "general", "geom", "equality", "pair")


@pytest.mark.one_of(8)
@pytest.mark.parametrize("kind", KINDS)
def test_each_attribute_of_the_schema_acts_as_in_mujoco_alone(tmp_path, kind):
    wrong = {}
    for name in attributes(kind):
        text = model_of({kind: {name: value(kind, name, Random(name))}})
        found, warned = difference(text, tmp_path)
        if not found <= 1e-9 and name not in warned:
            wrong[name] = found
    assert not wrong


@pytest.mark.parametrize(("tolerance", "differs"), [("0.4", True), ("1e-4", False)])
def test_moving_bodies_that_a_file_lets_sleep_are_reported(tmp_path, tolerance, differs):
    free = {
        "option": {"sleep_tolerance": tolerance},
        "flag": {"sleep": "enable"},
        "equality": {"active": "false"},
    }
    found, warned = difference(model_of(free), tmp_path)
    assert (found > 1e-3) is differs
    assert ("the flag sleep" in warned) is differs


def combined(numbers: range, folder: Path) -> dict[str, float]:
    """Return the models of random attributes that differ without a warning; some are invalid."""
    wrong, valid = {}, 0
    for number in numbers:
        random = Random(number)
        chosen = {
            kind: {name: value(kind, name, random) for name in random.sample(attributes(kind), 2)}
            for kind in KINDS
        }
        try:
            mujoco.MjModel.from_xml_string(model_of(chosen))
        except ValueError:
            continue
        valid += 1
        found, warned = difference(model_of(chosen), folder)
        bound = 1e-6 if "solver" in chosen["option"] else 1e-9  # CG and PGS end at MuJoCo's tolerance of 1e-8
        if not found <= bound and not any(name in warned for given in chosen.values() for name in given):
            wrong[repr(chosen)] = found
    assert valid > len(numbers) / 4
    return wrong


def test_random_attributes_together_act_as_in_mujoco_alone(tmp_path):
    assert not combined(range(12), tmp_path)


@pytest.mark.heavy
def test_many_random_attributes_together_act_as_in_mujoco_alone(tmp_path):
    assert not combined(range(12, 500), tmp_path)


def shaped(shape: str, ground: str = 'type="plane" size="2 2 1" pos="0 0 0.65"', asset: str = "") -> str:
    text = model_of({}).replace('name="tip" type="sphere" size="0.05"', f'name="tip" {shape}')
    text = text.replace('type="plane" size="2 2 1" pos="0 0 0.65"', ground)
    return text.replace("<worldbody>", f"<asset>{asset}</asset><worldbody>")


def test_an_ellipsoid_touches_as_in_mujoco_alone(tmp_path):
    found, _ = difference(shaped('type="ellipsoid" size="0.05 0.04 0.03"'), tmp_path)
    assert found <= 1e-9


def test_a_height_field_is_ground_as_in_mujoco_alone(tmp_path):
    elevation = " ".join(map(str, np.random.default_rng(1).random(20 * 30).round(3)))
    field = f'<hfield name="h" nrow="20" ncol="30" size="2 1 0.3 0.1" elevation="{elevation}"/>'
    ground = 'type="hfield" hfield="h" pos="0.1 0 0.55" euler="0 0.1 0.4"'
    found, warned = difference(shaped('type="sphere" size="0.05"', ground, field), tmp_path)
    assert found <= 1e-6  # meshes in files have numbers of 32 bits
    assert "height" not in warned


def test_the_settings_of_an_included_file_act(tmp_path):
    (tmp_path / "settings.xml").write_text('<mujoco><option cone="elliptic" timestep="0.0015"/></mujoco>')
    (tmp_path / "arm.xml").write_text(
        '<mujoco><include file="settings.xml"/><worldbody><body name="arm"><joint name="a"/><geom size="1"/>'
        "</body></worldbody></mujoco>"
    )
    backend = worlds().load("mujoco")
    with backend.open(read_scene(tmp_path / "arm.xml"), seed=1, options=backend.options()) as world:
        assert world.engine._model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
        assert world.engine.step_ns == 1_500_000
