"""Links that cannot move against each other are one body."""

from __future__ import annotations

from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.merged_bodies import bodies_of, body_of
from nrp_core.scene.model import Inertial, Joint, Link, Model
from nrp_core.scene.rigid import Pose

HERE = Pose((1.0, 2.0, 3.0))


def link(name: str, x: float = 0.0, mass: float = 1.0) -> Link:
    return Link(name, Pose((x, 0, 0)), Inertial(mass) if mass else None)


def joint(kind: str, parent: str, child: str, x: float = 0.0) -> Joint:
    return Joint(f"{parent}-{child}", kind, parent, child, Pose((x, 0, 0)))


def test_fixed_joints_merge_links_and_their_masses():
    model = Model(
        "m",
        (link("a"), link("b", 2.0), link("c", 4.0, mass=0)),
        (joint("fixed", "a", "b"), joint("fixed", "b", "c")),
        pose=HERE,
    )
    (body,) = bodies_of(model)
    assert [part.name for part in body.links] == ["a", "b", "c"]
    assert (body.name, body.parent, body.joint, body.fixed, body.pose) == ("a", None, None, False, HERE)
    assert body.inertial.mass == 2.0
    assert body.inertial.pose.position == (1.0, 0.0, 0.0)
    assert body.links[2].pose.position == (4.0, 0.0, 0.0)


def test_a_movable_joint_makes_a_body_in_the_joints_frame():
    model = Model("m", (link("a"), link("b", 2.5)), (joint("revolute", "a", "b", 2.0),), pose=HERE)
    base, arm = bodies_of(model)
    assert (arm.name, arm.parent, arm.joint.name) == ("b", 0, "a-b")
    assert arm.pose.position == arm.in_model.position == (2.0, 0.0, 0.0)
    assert arm.links[0].pose.position == (0.5, 0.0, 0.0)
    assert base.pose == HERE


def test_a_chain_gives_poses_in_the_parents_frame():
    model = Model(
        "m",
        (link("a"), link("b", 2.0), link("c", 5.0)),
        (joint("continuous", "b", "c", 5.0), joint("continuous", "a", "b", 2.0)),
    )
    bodies = bodies_of(model)
    assert [(body.name, body.parent, body.pose.position[0]) for body in bodies] == [
        ("a", None, 0),
        ("b", 0, 2),
        ("c", 1, 3),
    ]
    assert body_of(bodies, "c") == 2


def test_a_static_model_is_one_fixed_body_with_or_without_joints():
    model = Model("m", (link("a"), link("b", mass=0)), (joint("revolute", "a", "b"),), pose=HERE, static=True)
    (body,) = bodies_of(model)
    assert body.fixed
    assert body.inertial is None
    assert len(body.links) == 2


def test_a_joint_to_the_world_holds_a_link():
    model = Model(
        "m", (link("a"), link("b")), (joint("fixed", "world", "a"), joint("revolute", "a", "b")), pose=HERE
    )
    base, arm = bodies_of(model)
    assert (base.name, base.fixed, base.pose) == ("world", True, HERE)
    assert (arm.parent, arm.fixed) == (0, False)


def test_a_movable_joint_to_the_world_hangs_on_an_empty_fixed_body():
    model = Model("m", (link("a"),), (joint("revolute", "world", "a", 1.0),))
    base, arm = bodies_of(model)
    assert base.fixed
    assert not base.links
    assert arm.pose.position == (1.0, 0.0, 0.0)


def test_links_without_joints_float_apart():
    one, two = bodies_of(Model("m", (link("a"), link("b", 2.0)), pose=HERE))
    assert one.parent is two.parent is None
    assert one.pose == two.pose == HERE


def test_a_movable_body_needs_mass(golden: Golden):
    with golden.raises(SceneError, match="'b'.*'m'"):
        bodies_of(Model("m", (link("a"), link("b", mass=0)), (joint("revolute", "a", "b"),)))
