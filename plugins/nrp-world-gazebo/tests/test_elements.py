"""What Gazebo is told of a model is the model: the project's own reader of SDF reads it again."""

from math import pi

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree
from nrp_conformance.world.kit import pendulum, robot
from nrp_world_gazebo.elements import FIXED, element, model_element

from nrp_core.scene.inertia import inertia_tensor
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.rigid import matrix_of
from nrp_core.world import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Inertial,
    Joint,
    Link,
    Model,
    Pose,
    Sphere,
    read_model,
)

LENGTHS = st.floats(0.01, 3.0)
ANGLES = st.floats(-3.1, 3.1)
POSES = st.builds(
    lambda x, y, z, roll, pitch, yaw: Pose.from_rpy((x, y, z), roll, pitch / 2.2, yaw),
    LENGTHS, LENGTHS, LENGTHS, ANGLES, ANGLES, ANGLES,
)  # fmt: skip
SHAPES = st.one_of(
    st.builds(lambda x, y, z: Box((x, y, z)), LENGTHS, LENGTHS, LENGTHS),
    st.builds(Cylinder, LENGTHS, LENGTHS),
    st.builds(Sphere, LENGTHS),
)
INERTIALS = st.builds(
    lambda mass, pose, a, b, c: Inertial(mass, pose, (a + b, b + c, a + c, 0.0, 0.0, 0.0)),
    LENGTHS, POSES, LENGTHS, LENGTHS, LENGTHS,
)  # fmt: skip
KINDS = st.sampled_from(["revolute", "continuous", "prismatic"])


@st.composite
def arms(draw):
    collisions = tuple(Collision(f"c{i}", draw(SHAPES), draw(POSES), draw(LENGTHS)) for i in range(2))
    links = (
        Link("base", draw(POSES), draw(INERTIALS), (), collisions),
        Link("arm", draw(POSES), draw(INERTIALS)),
    )
    numbers = {name: draw(LENGTHS) for name in ("damping", "friction", "stiffness", "rest")}
    joint = Joint("joint", draw(KINDS), "base", "arm", draw(POSES), (0.0, 0.6, 0.8), -1.0, 2.0, **numbers)
    return Model("model", links, (joint,))


def written(model, folder):
    file = folder / "model.sdf"
    sdf = element("sdf", model_element(model, bodies_of(model), 0.002), version="1.6")
    file.write_bytes(etree.tostring(sdf))
    return read_model(file)


@given(arms())
@settings(max_examples=15, deadline=None)
def test_bodies_keep_mass_shapes_and_joint(tmp_path_factory, model):
    again = bodies_of(written(model, tmp_path_factory.mktemp("sdf")))
    for before, after in zip(bodies_of(model), again, strict=True):
        assert matrix_of(after.in_model) == pytest.approx(matrix_of(before.in_model), abs=1e-9)
        assert after.inertial.mass == before.inertial.mass
        assert after.inertial.pose.position == pytest.approx(before.inertial.pose.position)
        assert inertia_tensor(after.inertial) == pytest.approx(inertia_tensor(before.inertial), abs=1e-9)
        was = [(c, link.pose @ c.pose) for link in before.links for c in link.collisions]
        now = [(c, link.pose @ c.pose) for link in after.links for c in link.collisions]
        for (old, place), (new, there) in zip(was, now, strict=True):
            assert (new.geometry, new.friction) == (old.geometry, old.friction)
            assert matrix_of(there) == pytest.approx(matrix_of(place), abs=1e-9)
    (old,), (new,) = model.joints, [body.joint for body in again if body.joint]
    kept = ("name", "damping", "friction", "stiffness", "rest")
    assert [getattr(new, name) for name in kept] == [getattr(old, name) for name in kept]
    assert new.axis == pytest.approx(old.axis)
    if old.kind != "continuous":
        assert (new.kind, new.lower, new.upper) == (old.kind, old.lower, old.upper)


def test_links_that_are_fixed_to_each_other_are_one(tmp_path):
    again = written(robot(), tmp_path)
    assert "eye" not in [link.name for link in again.links]
    assert again.links[0].inertial.mass == pytest.approx(20.1)


def test_a_model_on_a_joint_to_the_world_hangs_on_a_fixed_link(tmp_path):
    again = written(pendulum(), tmp_path)
    assert [(joint.parent, joint.child) for joint in again.joints] == [("world", FIXED), (FIXED, "bob")]


def test_a_capsule_is_a_cylinder_and_two_spheres(tmp_path):
    lying = Pose.from_rpy((1.0, 0.0, 0.0), pi / 2, 0.0, 0.0)
    link = Link("link", inertial=Inertial(1.0), collisions=(Collision("c", Capsule(0.1, 0.4), lying),))
    shapes = written(Model("model", (link,)), tmp_path).links[0].collisions
    assert [shape.geometry for shape in shapes] == [Cylinder(0.1, 0.4), Sphere(0.1), Sphere(0.1)]
    assert shapes[1].pose.position == pytest.approx((1.0, 0.2, 0.0))
    assert shapes[2].pose.position == pytest.approx((1.0, -0.2, 0.0))
