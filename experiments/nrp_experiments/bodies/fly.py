"""A fruit fly as SDF, from its dimensions, in its true size: 2.5 mm long, 1 mg.

Lengths of the legs' parts are rounded values of *Drosophila melanogaster*; everything else is simplified.
Each leg has the seven joints that models of the fly usually have, from the body to the foot:

* ``coxa_yaw`` swings the leg, positive is forward on both sides; ``coxa_pitch`` lifts it,
* ``coxa_roll`` and ``femur_roll`` turn it about the axis of that part,
* ``femur_pitch`` lifts the femur, positive is up,
* ``tibia`` stretches the knee, ``tarsus`` the foot; positive moves the tip outwards.

With all joints at 0 the fly stands. ``proboscis`` is folded at 0 and extended at 1.5. The angle of a joint
such as ``front_left_tibia`` is commanded in radians on ``/<robot>/front_left_tibia/cmd_pos``. Each foot feels
its contacts: ``/<robot>/front_left_foot/touch``.

    python -m nrp_experiments.bodies.fly > fly.sdf
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import asin, cos, pi, radians, sin

from nrp_experiments.bodies.elements import (
    ball,
    bar,
    inertial,
    material,
    number,
    numbers,
    position_controller,
    visual,
)

SIDES = (("left", 1), ("right", -1))
JOINTS = ("coxa_yaw", "coxa_pitch", "coxa_roll", "femur_pitch", "femur_roll", "tibia", "tarsus")
MM = 1e-3
STIFF = 'priority="1" solref="0.0006 1" solimp="0.95 0.99 0.00001"'
"""Contacts for MuJoCo: time constant 0.6 ms, full resistance within 10 um."""
BROWN, PALE, RED, GLASS = "0.62 0.42 0.20", "0.80 0.62 0.36", "0.62 0.10 0.08", "0.80 0.84 0.88"


@dataclass(frozen=True)
class Pair:
    """A pair of legs: m, rad.

    Args:
        name: the place on the body.
        x: position of the hips along the body.
        heading: angle of the left leg from the front.
        coxa, femur, tibia, tarsus: lengths of the parts.
    """

    name: str
    x: float
    heading: float
    coxa: float
    femur: float
    tibia: float
    tarsus: float


@dataclass(frozen=True)
class Fly:
    """Dimensions of the fly: m, kg, N m, rad.

    Args:
        pairs: the legs.
        hips: half the distance between left and right hips, and their depth below the body's centre.
        clearance: height of the hips above the soles, standing.
        foot: radius of the feet; ``thick``: radius of the legs.
        drooping: angle of the coxa below the horizontal, standing.
        raised: angle of the femur above the horizontal; ``leaning``: of the tibia from the vertical.
        mass: mass of the body; ``leg_mass``: masses of a leg's links, as its joints.
        limit: limit of the joint angles, to both sides of 0.
        effort: limit of every joint's torque.
        stiffness, damping: gains of every joint's position controller.
    """

    pairs: tuple[Pair, ...] = (
        Pair("front", 0.30 * MM, radians(50), 0.40 * MM, 0.65 * MM, 0.55 * MM, 0.60 * MM),
        Pair("middle", 0.0, radians(90), 0.20 * MM, 0.75 * MM, 0.65 * MM, 0.65 * MM),
        Pair("hind", -0.25 * MM, radians(130), 0.20 * MM, 0.80 * MM, 0.70 * MM, 0.75 * MM),
    )
    hips: tuple[float, float] = (0.20 * MM, 0.25 * MM)
    clearance: float = 0.85 * MM
    foot: float = 0.04 * MM
    thick: float = 0.05 * MM
    drooping: float = radians(60)
    raised: float = radians(35)
    leaning: float = radians(15)
    mass: float = 0.85e-6
    leg_mass: tuple[float, ...] = (2e-9, 2e-9, 6e-9, 2e-9, 6e-9, 4e-9, 3e-9)
    limit: float = 1.6
    effort: float = 60e-9
    stiffness: float = 60e-9
    damping: float = 0.2e-9

    @property
    def height(self) -> float:
        """The height of the body's centre above the ground, standing."""
        return self.hips[1] + self.clearance + self.foot

    def flat(self, pair: Pair) -> float:
        """Return the angle of the tarsus below the horizontal with which its foot reaches the ground."""
        down = pair.coxa * sin(self.drooping) - pair.femur * sin(self.raised) + pair.tibia * cos(self.leaning)
        return asin((self.clearance - down) / pair.tarsus)


def sdf(robot: Fly, name: str = "fly") -> str:
    """Return the robot as a file."""
    legs = [(pair, side, sign) for side, sign in SIDES for pair in robot.pairs]
    joints = ["proboscis", *(f"{pair.name}_{side}_{joint}" for pair, side, _ in legs for joint in JOINTS)]
    lines = [
        '<?xml version="1.0"?>',
        "<!-- Made by nrp_experiments.bodies.fly, which describes the joints. -->",
        '<sdf version="1.9">',
        f'  <model name="{name}" xmlns:mujoco="urn:mujoco">',
        f"    <pose>0 0 {number(robot.height)} 0 0 0</pose>",
        *_body(robot),
        *_proboscis(robot),
    ]
    for leg in legs:
        lines += _leg(robot, *leg)
    for joint in joints:
        lines.append(f"    {position_controller(joint, robot.stiffness, robot.damping)}")
    return "\n".join([*lines, "  </model>", "</sdf>", ""])


def _body(robot: Fly) -> Iterator[str]:
    yield '    <link name="body">'
    yield f"      {inertial(robot.mass, (2.3 * MM, 0.8 * MM, 0.8 * MM))}"
    for name, radii, at, color in (
        ("thorax", (0.50, 0.40, 0.40), (0, 0, 0), BROWN),
        ("abdomen", (0.70, 0.42, 0.36), (-0.95, 0, -0.08, 0, -0.1, 0), PALE),
        ("head", (0.22, 0.36, 0.28), (0.62, 0, 0.05), BROWN),
        ("left_eye", (0.17, 0.14, 0.24), (0.66, 0.26, 0.08), RED),
        ("right_eye", (0.17, 0.14, 0.24), (0.66, -0.26, 0.08), RED),
        ("left_wing", (1.15, 0.36, 0.012), (-0.95, 0.30, 0.36, 0.15, 0.06, -0.16), GLASS),
        ("right_wing", (1.15, 0.36, 0.012), (-0.95, -0.30, 0.36, -0.15, 0.06, 0.16), GLASS),
    ):
        place = [value * MM for value in at[:3]] + list(at[3:])
        yield f"      {visual(name, _ellipsoid(radii), place, color)}"
    yield "    </link>"


def _proboscis(robot: Fly) -> Iterator[str]:
    size = 0.35 * MM
    yield '    <link name="proboscis_link">'
    yield f'      <pose relative_to="body">{numbers((0.70 * MM, 0, -0.15 * MM))} 0 2.6 0</pose>'
    yield f"      {inertial(4e-9, (size, 0.1 * MM, 0.1 * MM), size / 2)}"
    yield f"      {bar(size, 0.06 * MM, PALE)}"
    yield "    </link>"
    yield from _joint(robot, "proboscis", "body", "proboscis_link", "0 -1 0")


def _leg(robot: Fly, pair: Pair, side: str, sign: int) -> Iterator[str]:
    """Yield links and joints of a leg; in the frame of each link x points along the leg, y is level."""
    y, z = robot.hips
    drooping, raised, steep, flat = robot.drooping, robot.raised, pi / 2 - robot.leaning, robot.flat(pair)
    chain = (
        # position in the link before, pitch against it, axis, length
        ((pair.x, sign * y, -z), 0.0, f"0 0 {-sign}", 0.0),
        ((0.0, 0.0, 0.0), 0.0, "0 -1 0", 0.0),
        ((0.0, 0.0, 0.0), drooping, f"{sign} 0 0", pair.coxa),
        ((pair.coxa, 0.0, 0.0), -raised - drooping, "0 -1 0", 0.0),
        ((0.0, 0.0, 0.0), 0.0, f"{sign} 0 0", pair.femur),
        ((pair.femur, 0.0, 0.0), raised + steep, "0 -1 0", pair.tibia),
        ((pair.tibia, 0.0, 0.0), flat - steep, "0 -1 0", pair.tarsus),
    )
    before = "body"
    for joint, (at, pitch, axis, length), mass in zip(JOINTS, chain, robot.leg_mass, strict=True):
        name = f"{pair.name}_{side}_{joint}"
        link = f"{name}_link"
        yaw = sign * pair.heading if joint == "coxa_yaw" else 0.0
        yield f'    <link name="{link}">'
        yield f'      <pose relative_to="{before}">{numbers((*at, 0.0, pitch, yaw))}</pose>'
        yield f"      {inertial(mass, (max(length, robot.thick), robot.thick, robot.thick), length / 2)}"
        if length:
            yield f"      {bar(length, robot.thick * (0.6 if joint == 'tarsus' else 1.0), BROWN)}"
        if joint == "tarsus":
            yield from _foot(robot, length, f"{pair.name}_{side}_foot/touch")
        yield "    </link>"
        if joint == "tarsus":
            yield f'    <mujoco:geom link="{link}" {STIFF}/>'
        yield from _joint(robot, name, before, link, axis)
        before = link


def _foot(robot: Fly, length: float, topic: str) -> Iterator[str]:
    foot = f"<pose>{number(length)} 0 0 0 0 0</pose>{ball(robot.foot)}"
    yield f'      <visual name="foot">{foot}{material("0.1 0.1 0.1")}</visual>'
    yield f'      <collision name="foot">{foot}</collision>'
    yield '      <sensor name="foot" type="contact"><update_rate>100</update_rate>'
    yield "        <contact><collision>foot</collision>"
    yield f"          <topic>{topic}</topic></contact></sensor>"


def _joint(robot: Fly, name: str, parent: str, child: str, axis: str) -> Iterator[str]:
    yield f'    <joint name="{name}" type="revolute">'
    yield f"      <parent>{parent}</parent><child>{child}</child>"
    yield f"      <axis><xyz>{axis}</xyz>"
    yield f"        <limit><lower>{number(-robot.limit)}</lower><upper>{number(robot.limit)}</upper>"
    yield f"          <effort>{number(robot.effort)}</effort></limit></axis>"
    yield "    </joint>"


def _ellipsoid(radii_mm: tuple[float, float, float]) -> str:
    radii = numbers([radius * MM for radius in radii_mm])
    return f"<geometry><ellipsoid><radii>{radii}</radii></ellipsoid></geometry>"


if __name__ == "__main__":
    print(sdf(Fly()), end="")
