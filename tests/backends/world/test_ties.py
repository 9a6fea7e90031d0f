"""Joints of a world between two models, on both engines, against one model with the same joint."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from golden import Golden

from nrp_core.findings import Findings
from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_scene
from nrp_core.world.capabilities import WorldCapabilities, check_scene

BODY = (
    '<link name="{0}"><pose>{1} 0 0 0 0 0</pose><inertial><pose>0.25 0 0 0 0 0</pose><mass>{2}</mass>'
    "<inertia><ixx>0.01</ixx><iyy>0.02</iyy><izz>0.02</izz></inertia></inertial>{3}</link>"
)
BLOCK = (
    '<collision name="c"><pose>0.25 0 0 0 0 0</pose><geometry><box><size>0.6 0.1 0.1</size></box></geometry>'
    "</collision>"
)
JOINT = (
    '<joint name="{0}" type="{1}"><parent>{2}</parent><child>{3}</child><axis><xyz>0 1 0</xyz></axis></joint>'
)
HELD = JOINT.format("hinge", "revolute", "world", "{}")
TURNED = f"<pose>0 1 2 0 0 {pi / 2}</pose>"
ENDS = ("arm", "l"), ("load", "l")


def two(kind: str, *, touch: bool = False) -> str:
    """Return an arm that turns about an axis in the world, and another model that is tied to its end."""
    solid = BLOCK if touch else ""
    return (
        f'<model name="arm">{TURNED}{BODY.format("l", 0, 1.0, solid)}{HELD.format("l")}</model>'
        f'<model name="load"><pose>0 1.5 2 0 0 {pi / 2}</pose>{BODY.format("l", 0, 2.0, solid)}</model>'
        + JOINT.format("tie", kind, "arm::l", "load")
    )


def one(kind: str) -> str:
    """Return the same bodies as one model."""
    links = BODY.format("l", 0, 1.0, "") + BODY.format("load", 0.5, 2.0, "")
    joints = HELD.format("l") + JOINT.format("tie", kind, "l", "load")
    return f'<model name="arm">{TURNED}{links}{joints}</model>'


RAIL = """<joint name="{0}" type="prismatic"><parent>{1}</parent><child>{2}</child><axis><xyz>1 0 0</xyz>{3}
</axis></joint>"""
CROSS = """<joint name="{0}" type="universal"><parent>{1}</parent><child>{2}</child>
<axis><xyz>0 1 0</xyz></axis><axis2><xyz>0 0 1</xyz></axis2></joint>"""
STOPS = "<limit><lower>-0.1</lower><upper>0.2</upper></limit><dynamics><damping>3</damping></dynamics>"


def with_joint(scene: str, joint: str, *inside: str) -> str:
    """Return a scene with another joint in the place of the tie."""
    head, _, rest = scene.partition('<joint name="tie"')
    return head + joint.format("tie", *inside) + rest.partition("</joint>")[2]


@pytest.fixture
def room(tmp_path):
    """Read the contents of a world."""

    def read(body: str) -> Scene:
        (tmp_path / "room.sdf").write_text(f'<sdf version="1.11"><world name="w">{body}</world></sdf>')
        return read_scene(tmp_path / "room.sdf")

    return read


def places(world, *links: tuple[str, str]) -> np.ndarray:
    """Return where each link is, and where its x axis points."""
    poses = [world.link_motion(*link).pose for link in links]
    return np.array([(*pose.position, *pose.rotate((1.0, 0.0, 0.0))) for pose in poses])


@pytest.mark.parametrize("kind", ["fixed", "revolute", "ball"])
def test_two_models_move_as_one_with_the_same_joint(open_world, advance, room, kind: str) -> None:
    """They fall from where they point along y."""
    scene = room(two(kind))
    assert (scene.warnings, [tie.kind for tie in scene.ties]) == (
        (),
        [kind.replace("revolute", "continuous")],
    )
    tied, whole = open_world(scene), open_world(room(one(kind)))
    for _ in range(5):
        advance(tied, 0.1)
        advance(whole, 0.1)
        found = places(tied, *ENDS)
        assert found == pytest.approx(places(whole, ("arm", "l"), ("arm", "load")), abs=1e-2)
    assert found[0, 2] == pytest.approx(2.0, abs=1e-6)
    assert found[1, 2] < 1.7, "they have fallen"


@pytest.mark.parametrize("limits", ["", STOPS])
@pytest.mark.parametrize("joint", [RAIL, CROSS])
def test_models_slide_or_turn_about_two_axes_as_one_model_does(
    open_world, advance, room, joint: str, limits: str
) -> None:
    """The arm falls, and lets its load slide off, or down and aside."""
    scene = room(with_joint(two("fixed"), joint, "arm::l", "load", limits))
    assert scene.warnings == ()
    tied = open_world(scene)
    whole = open_world(room(with_joint(one("fixed"), joint, "l", "load", limits)))
    if type(tied.engine).__name__ == "PybulletEngine" and (joint == CROSS or limits):
        said = [each.message for each in tied.warnings if each.subject == "tie"]
        kind, lacking = ("universal", "apart") if joint == CROSS else ("prismatic", "slide without limits")
        assert [(f"is {kind}: PyBullet" in each, lacking in each) for each in said] == [(True, True)]
        return
    assert not tied.warnings
    for _ in range(5):
        advance(tied, 0.1)
        advance(whole, 0.1)
        found = places(tied, *ENDS)
        assert found == pytest.approx(places(whole, ("arm", "l"), ("arm", "load")), abs=2e-2)
    assert found[1, 2] < 1.7, "it has fallen"


def test_a_rail_holds_what_slides_on_it_across(open_world, advance, room) -> None:
    """A load of 2 kg stands 0.5 m before a static post, and slides only up and down."""
    post = '<model name="post"><static>1</static><pose>0 0 2 0 0 0</pose><link name="l"/></model>'
    load = f'<model name="load"><pose>0.5 0 2 0 0 0</pose>{BODY.format("l", 0, 2.0, "")}</model>'
    rail = RAIL.format("tie", "post", "load", "").replace("1 0 0", "0 0 1")
    world = open_world(room(post + load + rail))
    advance(world, 0.5)
    motion = world.model_motion("load")
    assert motion.pose.position == pytest.approx((0.5, 0.0, 2 - 9.8 * 0.5**2 / 2), abs=0.02)
    assert motion.pose.rotate((1.0, 0.0, 0.0)) == pytest.approx((1, 0, 0), abs=2e-3)


def test_bodies_that_are_tied_do_not_push_each_other_apart(open_world, advance, room) -> None:
    """Their blocks overlap by 10 cm."""
    blocks, bare = open_world(room(two("revolute", touch=True))), open_world(room(two("revolute")))
    advance(blocks, 0.3)
    advance(bare, 0.3)
    assert places(blocks, *ENDS) == pytest.approx(places(bare, *ENDS), abs=1e-6)


def test_a_model_may_be_tied_to_one_that_stands_still(open_world, advance, room) -> None:
    for parent, child in (("post", "load"), ("load", "post")):
        post = '<model name="post"><static>1</static><pose>0 0 2 0 0 0</pose><link name="l"/></model>'
        load = f'<model name="load"><pose>0.2 0 2 0 0 0</pose>{BODY.format("l", 0, 2.0, "")}</model>'
        world = open_world(room(post + load + JOINT.format("tie", "fixed", parent, child)))
        advance(world, 0.5)
        assert world.model_motion("load").pose.position == pytest.approx((0.2, 0, 2), abs=2e-3)


def test_a_tie_goes_on_from_a_snapshot_and_after_a_reset(open_world, advance, room, require_to_go_on) -> None:
    scene = room(two("revolute"))
    world, again = open_world(scene), open_world(scene)
    advance(world, 0.1)
    require_to_go_on(world, again, 0.2, lambda each: places(each, *ENDS).tolist())
    world.reset()
    advance(world, 0.3)
    assert places(world, *ENDS) == pytest.approx(places(again, *ENDS), abs=1e-9)


def test_a_model_is_free_when_the_other_one_is_deleted(open_world, advance, room) -> None:
    scene = room(two("revolute"))
    world = open_world(scene)
    advance(world, 0.1)
    world.delete("arm")
    centre = scene.model("load").links[0].inertial.pose
    before = world.model_motion("load").at(centre)
    advance(world, 0.2)
    fall = before.linear[2] * 0.2 - 9.8 * 0.2**2 / 2
    after = world.model_motion("load").at(centre).pose.position
    assert after[2] - before.pose.position[2] == pytest.approx(fall, abs=0.01)


def test_an_engine_that_leaves_models_apart_says_so(room, golden: Golden) -> None:
    scene, warnings = room(two("fixed")), Findings()
    able = WorldCapabilities(step_ns=2_000_000, dynamics=True, loops=True)
    check_scene(scene, able, "this engine", warnings)
    assert not warnings
    check_scene(scene, replace(able, loops=False), "this engine", warnings)
    (warning,) = warnings
    assert "'tie'" in str(warning)
    golden(str(warning))
