"""The contacts that the <surface> of a collision asks for."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.model import Model

ModelReader = Callable[..., Model]

BALL = (
    '<link name="base"><inertial auto="true"/><collision name="c">'
    "<geometry><sphere><radius>0.1</radius></sphere></geometry>\n<surface>{}</surface></collision></link>"
)
CONTACT = "<contact>{}</contact>"


def test_a_collision_without_bits_touches_nothing_but_has_its_mass(model: ModelReader) -> None:
    for bits in ("0", "0x00"):
        read = model(BALL.format(CONTACT.format(f"<collide_bitmask>{bits}</collide_bitmask>")))
        assert read.links[0].collisions == ()
        assert read.links[0].inertial.mass == pytest.approx(4.18879)  # type: ignore[union-attr]
        assert read.warnings == ()


@pytest.mark.parametrize(
    ("surface", "told"),
    [
        (
            "<bounce><restitution_coefficient>0.8</restitution_coefficient></bounce>",
            "the <restitution_coefficient> of a <bounce> is not simulated",
        ),
        (
            CONTACT.format("<collide_without_contact>true</collide_without_contact>"),
            "<collide_without_contact> is not simulated",
        ),
    ],
)
def test_contacts_that_are_not_simulated_are_reported(model: ModelReader, surface: str, told: str) -> None:
    read = model(BALL.format(surface))
    (warning,) = read.warnings
    assert str(warning).split(": ", 1)[1].startswith(told)
    assert "robot.sdf:5:" in str(warning)
    assert len(read.links[0].collisions) == 1


@pytest.mark.parametrize(
    "surface",
    [
        "<bounce><restitution_coefficient>0.0</restitution_coefficient><threshold>1e+06</threshold></bounce>",
        "<bounce/><contact/>",
        CONTACT.format("<collide_without_contact>0</collide_without_contact>"),
        CONTACT.format("<collide_bitmask>65535</collide_bitmask><category_bitmask>0xffff</category_bitmask>"),
        CONTACT.format("<collide_bitmask>0xffffffff</collide_bitmask>"),
        CONTACT.format("<collide_without_contact_bitmask>1</collide_without_contact_bitmask>"),
    ],
)
def test_the_contacts_of_a_saved_model_are_usual(model: ModelReader, surface: str) -> None:
    read = model(BALL.format(surface))
    assert (read.warnings, len(read.links[0].collisions)) == ((), 1)


@pytest.mark.parametrize(
    ("contact", "bits"),
    [
        ("<collide_bitmask>0x02</collide_bitmask>", (2, 2)),
        ("<category_bitmask>1</category_bitmask>", (1, 0xFFFF)),
        ("<collide_bitmask>0</collide_bitmask><category_bitmask>4</category_bitmask>", (4, 0)),
    ],
)
def test_a_category_is_what_a_collision_touches_unless_the_file_says_more(
    model: ModelReader, contact: str, bits: tuple[int, int]
) -> None:
    """As in sdformat's description of ``<category_bitmask>``."""
    read = model(BALL.format(CONTACT.format(contact)))
    ((shape,), warnings) = read.links[0].collisions, read.warnings
    assert ((shape.category, shape.touched), warnings) == (bits, ())


def test_bits_that_are_not_a_number_are_refused(model: ModelReader, golden: Golden) -> None:
    with golden.raises(SceneError, match=r"robot\.sdf:5: <collide_bitmask>"):
        model(BALL.format(CONTACT.format("<collide_bitmask>none</collide_bitmask>")))
