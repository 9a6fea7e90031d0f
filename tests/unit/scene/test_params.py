"""Changes that an <include> makes to the model that it includes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.errors import SceneError
from nrp_core.scene.model import Box, Model, Scene, Sphere

WorldReader = Callable[..., Scene]

CART = (
    '<sdf version="1.9"><model name="cart"><link name="base"><inertial><mass>2</mass></inertial>'
    '<visual name="shell"><geometry><box><size>1 1 1</size></box></geometry><transparency>0.5</transparency>'
    '</visual><visual name="lamp"><geometry><box><size>1 1 1</size></box></geometry></visual>'
    '<sensor name="eye" type="camera"><update_rate>10</update_rate><topic>seen</topic>'
    "<camera><image><width>32</width><height>24</height></image></camera></sensor></link>"
    '<model name="arm"><link name="hand"><inertial/></link></model></model></sdf>'
)
BALL = "<geometry><sphere><radius>0.2</radius></sphere></geometry>"


@pytest.fixture
def cart(world: WorldReader, tmp_path: Path) -> Callable[[str], Model]:
    """Include a cart with changes, the first line of which is line 6 of the file."""
    (tmp_path / "cart.sdf").write_text(CART)

    def read(changes: str) -> Model:
        params = f'<experimental:params xmlns:experimental="x">\n{changes}\n</experimental:params>'
        scene = world(f"<include>\n<uri>cart.sdf</uri>{params}</include>")
        assert scene.warnings == ()
        return scene.models[0]

    return read


def test_parts_are_added(cart: Callable[[str], Model]) -> None:
    model = cart(
        f'<visual element_id="base" name="ball" action="add"><pose>0 0 1 0 0 0</pose>{BALL}</visual>'
        '<link element_id="" name="tail" action="add"><inertial><mass>3</mass></inertial></link>'
        f'<visual element_id="arm::hand" name="thumb" action="add">{BALL}</visual>'
    )
    ball = model.link("base").visuals[-1]
    assert (ball.name, ball.geometry, ball.pose.position) == ("ball", Sphere(0.2), (0, 0, 1))
    assert model.link("tail").inertial.mass == 3  # type: ignore[union-attr]
    assert [visual.name for visual in model.link("arm::hand").visuals] == ["thumb"]


def test_parts_are_removed(cart: Callable[[str], Model]) -> None:
    model = cart(
        '<sensor element_id="base::eye" action="remove"/><visual element_id="base::lamp" action="remove"/>'
        '<visual element_id="base::shell" action="remove"><transparency/></visual>'
    )
    (shell,) = model.link("base").visuals
    assert (model.link("base").sensors, shell.name, shell.rgba[3]) == ((), "shell", 1.0)


def test_values_are_modified(cart: Callable[[str], Model]) -> None:
    model = cart(
        '<sensor element_id="base::eye" action="modify"><update_rate>50</update_rate>'
        "<camera><image><width>64</width></image></camera></sensor>"
    )
    (eye,) = model.link("base").sensors
    assert (eye.rate_hz, eye.width, eye.height) == (50, 64, 24)  # type: ignore[attr-defined]


def test_a_part_is_replaced_and_keeps_its_name(cart: Callable[[str], Model]) -> None:
    model = cart(f'<visual element_id="base::shell" action="replace">{BALL}</visual>')
    shell, lamp = model.link("base").visuals
    assert (shell.name, shell.geometry, shell.rgba[3]) == ("shell", Sphere(0.2), 1.0)
    assert lamp.geometry == Box((1, 1, 1))


def test_each_child_may_say_what_becomes_of_it(cart: Callable[[str], Model]) -> None:
    other = BALL.replace("<geometry>", '<geometry action="replace">')
    model = cart(
        '<link element_id="base"><sensor name="eye" action="remove"/>'
        f'<visual name="ball" action="add">{BALL}</visual>'
        '<inertial action="modify"><mass>5</mass></inertial></link>'
        f'<visual element_id="base::lamp">{other}</visual>'
    )
    base = model.link("base")
    assert (base.sensors, base.inertial.mass) == ((), 5)  # type: ignore[union-attr]
    assert [(each.name, type(each.geometry)) for each in base.visuals] == [
        ("shell", Box), ("lamp", Sphere), ("ball", Sphere),
    ]  # fmt: skip


def test_the_file_itself_stays_as_it_is(world: WorldReader, tmp_path: Path) -> None:
    (tmp_path / "cart.sdf").write_text(CART)
    changes = (
        '<experimental:params xmlns:experimental="x"><visual element_id="base::lamp" action="remove"/>'
        "</experimental:params>"
    )
    include = "<include><name>{}</name><uri>cart.sdf</uri>{}</include>"
    scene = world(include.format("bare", changes) + include.format("whole", ""))
    counts = {model.name: len(model.link("base").visuals) for model in scene.models}
    assert counts == {"bare": 1, "whole": 2}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ('<visual action="remove"/>', "<visual> in <experimental:params> needs an attribute element_id"),
        ('<visual element_id="base::lump" action="remove"/>', "no <visual> 'base::lump'"),
        ('<sensor element_id="base::lamp" action="remove"/>', "no <sensor> 'base::lamp'"),
        ('<visual element_id="bass" name="b" action="add"/>', "no element 'bass'"),
        ('<visual element_id="base" action="add"/>', '<visual> needs an attribute name="..."'),
        ('<visual element_id="base" name="lamp" action="add"/>', "has a <visual> 'lamp' there already"),
        ('<visual element_id="base::lamp" action="removed"/>', "no action 'removed'; did you mean 'remove'"),
        ('<visual element_id="base::lamp"><transparency>1</transparency></visual>', 'needs an action="..."'),
        (
            '<visual element_id="base::lamp"><transparency action="remove"/></visual>',
            "no <transparency> to remove in its <visual>",
        ),
        (
            '<visual element_id="base::lamp" action="modify"><transparency>1</transparency></visual>',
            "no <transparency> to modify in its <visual>",
        ),
    ],
)
def test_changes_that_cannot_be_made_are_refused(
    cart: Callable[[str], Model], changes: str, message: str
) -> None:
    with pytest.raises(SceneError) as refused:
        cart(changes)
    assert "room.sdf:6: " in str(refused.value)
    assert message in str(refused.value)
