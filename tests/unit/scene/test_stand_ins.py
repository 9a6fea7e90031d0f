"""What stands in for a mesh has a size that follows from the rest of the model, or from the room."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nrp_core.scene.model import Box, Link, Model, Plane, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.scene.stand_in import DENSITIES, LARGEST_BOX_M

MESH = "<geometry><mesh><uri>model://gone/mesh.dae</uri></mesh></geometry>"
SHAPES = f'<visual name="v">{MESH}</visual><collision name="c">{MESH}</collision>'


def inertial(mass: float, moment: float, at: str = "0 0 0") -> str:
    moments = "".join(f"<i{axis}>{moment}</i{axis}>" for axis in ("xx", "yy", "zz"))
    return f"<inertial><pose>{at} 0 0 0</pose><mass>{mass}</mass><inertia>{moments}</inertia></inertial>"


def link(name: str, x: float, content: str) -> str:
    return f'<link name="{name}"><pose>{x} 0 0 0 0 0</pose>{content}</link>'


def joint(parent: str, child: str) -> str:
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="to_{child}" type="revolute">{ends}<axis><xyz>0 0 1</xyz></axis></joint>'


def box_of(model: Model, name: str) -> tuple[Box, Pose]:
    (shown,), (touched,) = model.link(name).visuals, model.link(name).collisions
    assert isinstance(touched.geometry, Box)
    assert (shown.geometry, shown.pose) == (touched.geometry, touched.pose)
    return touched.geometry, touched.pose


@pytest.fixture
def arm(model: Callable[[str], Model]) -> Model:
    """An arm along x: bones of 0.3 m and 0.25 m, and a hand whose inertia is that of a box of 0.53 m."""
    return model(
        link("base", 0.0, inertial(5, 1) + '<collision name="c"><geometry><sphere><radius>0.1</radius>'
             "</sphere></geometry></collision>")
        + link("upper", 0.2, inertial(1.2, 0.08, "0.15 0 0") + SHAPES)
        + link("lower", 0.5, inertial(0.8, 0.06, "0.12 0 0") + SHAPES)
        + link("hand", 0.75, inertial(0.2, 0.0094, "0.05 0 0") + SHAPES)
        + joint("base", "upper") + joint("upper", "lower") + joint("lower", "hand")
    )  # fmt: skip


def test_a_bone_spans_its_joints(arm: Model) -> None:
    for name, length, mass in (("upper", 0.3, 1.2), ("lower", 0.25, 0.8)):
        box, pose = box_of(arm, name)
        assert box.size[0] == pytest.approx(length)
        assert pose.position == pytest.approx((length / 2, 0.0, 0.0))
        assert np.prod(box.size) == pytest.approx(mass / 1000)  # as heavy as water


def test_a_hand_reaches_as_far_beyond_its_centre_of_mass_as_its_joint_is_before_it(arm: Model) -> None:
    box, pose = box_of(arm, "hand")
    assert box.size == pytest.approx((0.1, 0.2e-3**0.5 / 0.1**0.5, 0.2e-3**0.5 / 0.1**0.5))
    assert pose.position == pytest.approx((0.05, 0.0, 0.0))


def test_a_hand_of_its_centre_alone_is_a_cube_of_its_mass_no_larger_than_the_bone_before_it(
    model: Callable[[str], Model],
) -> None:
    def hand(mass: float) -> Box:
        bones = link("base", 0.0, inertial(5, 1)) + link("arm", 0.1, inertial(0.1, 1e-4))
        text = bones + link("hand", 0.2, inertial(mass, 1.0) + SHAPES) + joint("base", "arm")
        return box_of(model(text + joint("arm", "hand")), "hand")[0]

    assert hand(0.2).size == pytest.approx((0.2e-3 ** (1 / 3),) * 3)
    assert hand(8.0).size == pytest.approx((0.1,) * 3)  # its mass would make 0.2 m


@pytest.mark.parametrize("density", [DENSITIES[0] * 1.1, 1000.0, DENSITIES[1] * 0.9])
def test_an_inertia_that_a_body_can_have_is_kept(model: Callable[[str], Model], density: float) -> None:
    mass = density * 0.2**3
    box, _ = box_of(model(link("cube", 0.0, inertial(mass, mass / 6 * 0.2**2) + SHAPES)), "cube")
    assert box.size == pytest.approx((0.2,) * 3)


@pytest.mark.parametrize("height", [0.02, 0.3, 0.5])
def test_a_guessed_box_is_where_its_collision_is_and_ends_at_the_bottom_of_the_wheels(
    model: Callable[[str], Model], height: float
) -> None:
    """A base of 1000 kg, whose inertia is that of a cube of 0.78 m, on a wheel that touches the ground."""
    base = inertial(1000, 101.4) + SHAPES.replace(
        '<collision name="c">', f'<collision name="c"><pose>0 0 {height} 0 0 0</pose>'
    )
    ball = "<geometry><sphere><radius>0.1</radius></sphere></geometry>"
    wheel = f'<collision name="c"><pose>0 0 0.1 0 0 0</pose>{ball}</collision>'
    read = model(
        link("base", 0.0, base) + link("wheel", 0.0, inertial(5, 0.02) + wheel) + joint("base", "wheel")
    )
    box, pose = box_of(read, "base")
    low, high = max(0.0, height - 0.39), height + 0.39
    assert box.size == pytest.approx((0.78, 0.78, high - low), rel=1e-2)
    assert pose.position == pytest.approx((0.0, 0.0, (low + high) / 2), abs=2e-3)


def test_a_collision_shape_takes_the_extent_of_the_visual(model: Callable[[str], Model]) -> None:
    seen = (
        '<visual name="v"><pose>0 0 1 0 0 0</pose><geometry><box><size>1 2 3</size></box></geometry></visual>'
    )
    read = model(link("body", 0.0, inertial(5, 1) + seen + f'<collision name="c">{MESH}</collision>'))
    assert read.links[0].collisions[0].geometry == Box((1.0, 2.0, 3.0))
    assert read.links[0].collisions[0].pose.position == pytest.approx((0.0, 0.0, 1.0))


# -- what never moves


def prop(name: str, pose: str, content: str = SHAPES) -> str:
    return (
        f'<model name="{name}"><static>1</static><pose>{pose}</pose><link name="l">{content}</link></model>'
    )


def shape(scene: Scene, name: str) -> tuple[Link, object, Pose]:
    (found,) = scene.model(name).links
    (touched,) = found.collisions
    return found, touched.geometry, scene.model(name).pose @ found.pose @ touched.pose


def test_a_lost_ground_is_a_plane_where_its_model_stands(world: Callable[..., Scene]) -> None:
    scene = world(prop("table", "1 0 0 0 0 0") + prop("lab_floor", "3 0 -0.2 1.5707963 0 0"))
    _, geometry, pose = shape(scene, "lab_floor")
    assert isinstance(geometry, Plane)
    assert pose.position[2] == pytest.approx(-0.2)
    assert pose.rotate((0.0, 0.0, 1.0)) == pytest.approx((0.0, 0.0, 1.0))
    assert any("'lab_floor' is taken for the ground" in each.message for each in scene.warnings)
    assert isinstance(shape(scene, "table")[1], Box)


@pytest.mark.parametrize(
    ("name", "content", "is_ground"),
    [
        ("hall", SHAPES, True),
        ("scenery", SHAPES.replace('name="', 'name="floor_', 1), True),
        ("cupboard", SHAPES, False),
    ],
)
def test_a_ground_is_known_by_its_model_or_its_parts(
    world: Callable[..., Scene], name: str, content: str, is_ground: bool
) -> None:
    scene = world(prop("table", "1 0 0 0 0 0") + prop(name, "0 0 0 0 0 0", content))
    assert isinstance(shape(scene, name)[1], Plane) == is_ground
    assert isinstance(shape(scene, "table")[1], Box)


def test_a_room_with_a_ground_does_not_get_a_second_one(world: Callable[..., Scene]) -> None:
    floor = '<collision name="c"><geometry><plane/></geometry></collision>'
    scene = world(prop("ground", "0 0 0 0 0 0", floor) + prop("lab_floor", "4 0 0 0 0 0"))
    assert isinstance(shape(scene, "lab_floor")[1], Box)
    assert not any("taken for the ground" in each.message for each in scene.warnings)


def test_boxes_leave_room_for_their_neighbours_and_for_a_robot_at_the_origin(
    world: Callable[..., Scene],
) -> None:
    scene = world(
        prop("table", "2 0 0 0 0 0") + prop("chair", "2 0.3 0 0 0 0") + prop("lamp", "-0.4 0 1.5 0 0 0")
        + prop("shelf", "0 6 0 0 0 0")
    )  # fmt: skip
    sizes = {name: shape(scene, name) for name in ("table", "chair", "lamp", "shelf")}
    edges = {name: geometry.size[0] for name, (_, geometry, _) in sizes.items() if isinstance(geometry, Box)}
    assert edges == pytest.approx({"table": 0.15, "chair": 0.15, "lamp": 0.2, "shelf": LARGEST_BOX_M})
    assert sizes["table"][2].position == pytest.approx((2.0, 0.0, 0.075))  # on the ground
    assert sizes["lamp"][2].position == pytest.approx((-0.4, 0.0, 1.5))  # where it hangs
