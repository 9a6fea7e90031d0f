"""A six-legged walker as SDF, from its dimensions.

Each leg has four joints, like the walking machine LAURON V (A. Roennau et al., "LAURON V: a versatile
six-legged walking robot with advanced maneuverability", AIM 2014), from the body to the foot:

* ``delta`` tilts the leg about the axis of the body; positive lifts it,
* ``alpha`` swings it; positive is forward on both sides,
* ``beta`` lifts the thigh; positive is up,
* ``gamma`` stretches the knee; positive moves the foot outwards.

With all joints at 0 the robot stands. The angle of a joint such as ``front_left_alpha`` is commanded in
radians on ``/<robot>/front_left_alpha/cmd_pos``.

    python -m nrp_experiments.bodies.hexapod > hexapod.sdf
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, pi, radians, sin

from nrp_experiments.bodies.elements import ball, bar, box, inertial, material, position_controller, visual
from nrp_experiments.bodies.elements import number as _

SIDES = (("left", 1), ("right", -1))
PLACES = (("front", 1), ("middle", 0), ("rear", -1))
JOINTS = ("delta", "alpha", "beta", "gamma")
ORANGE, DARK = "0.85 0.45 0.10", "0.20 0.20 0.22"


@dataclass(frozen=True)
class Hexapod:
    """Dimensions of the walker: m, kg, N m, rad.

    Args:
        body: length, width and height.
        thick: radius of the legs.
        coxa, thigh, shin: lengths of a leg's parts; the shin ends in a ball.
        raised: angle of the thigh above the horizontal, standing.
        leaning: angle of the shin from the vertical, outwards, standing.
        splay: angle by which front and rear legs point forward and back.
        mass: mass of the body; ``leg_mass``: masses of the parts of a leg, from the body to the foot.
        limits: limits of the joint angles, to both sides of 0.
        effort: limit of every joint's torque.
        stiffness, damping: gains of every joint's position controller.
    """

    body: tuple[float, float, float] = (0.62, 0.20, 0.11)
    thick: float = 0.022
    coxa: float = 0.08
    thigh: float = 0.17
    shin: float = 0.25
    raised: float = radians(35)
    leaning: float = radians(8)
    splay: float = radians(25)
    mass: float = 9.0
    leg_mass: tuple[float, float, float, float] = (0.25, 0.3, 0.5, 0.35)
    limits: tuple[float, float, float, float] = (0.5, 0.8, 1.0, 1.0)
    effort: float = 40.0
    stiffness: float = 250.0
    damping: float = 6.0

    @property
    def height(self) -> float:
        """The height of the body's centre above the ground, standing."""
        return self.shin * cos(self.leaning) - self.thigh * sin(self.raised) + self.thick

    def legs(self) -> Iterator[Leg]:
        """Yield the legs: left then right, from front to rear."""
        length, width, _ = self.body
        for side, sign in SIDES:
            for place, along in PLACES:
                heading = sign * (pi / 2 - along * self.splay)
                yield Leg(f"{place}_{side}", sign, (along * 0.42 * length, sign * width / 2), heading)


@dataclass(frozen=True)
class Leg:
    """A leg's place on the body, the side it is on (1 for left), and where it points, as a yaw."""

    name: str
    side: int
    at: tuple[float, float]
    heading: float


def sdf(robot: Hexapod, name: str = "hexapod") -> str:
    """Return the robot as a file."""
    lines = [
        '<?xml version="1.0"?>',
        "<!-- Made by nrp_experiments.bodies.hexapod, which describes the joints. -->",
        '<sdf version="1.9">',
        f'  <model name="{name}">',
        f"    <pose>0 0 {_(robot.height)} 0 0 0</pose>",
        *_body(robot),
    ]
    for leg in robot.legs():
        lines += _leg(robot, leg)
    for leg in robot.legs():
        for joint in JOINTS:
            name_of_joint = f"{leg.name}_{joint}"
            lines.append(f"    {position_controller(name_of_joint, robot.stiffness, robot.damping)}")
    return "\n".join([*lines, "  </model>", "</sdf>", ""])


def _body(robot: Hexapod) -> Iterator[str]:
    length, width, height = robot.body
    front = 0.54 * length
    yield '    <link name="body">'
    yield f"      {inertial(robot.mass, robot.body)}"
    yield f'      <collision name="body">{box(robot.body)}</collision>'
    for name, size, at, color in (
        ("hull", (length, width, 0.6 * height), (0, 0, 0), ORANGE),
        ("back", (0.8 * length, 0.7 * width, 0.4 * height), (-0.03, 0, 0.5 * height), DARK),
        ("head", (0.10, 0.6 * width, 0.5 * height), (front, 0, 0.1 * height), "0.92 0.92 0.90"),
        ("eyes", (0.01, 0.4 * width, 0.15 * height), (front + 0.052, 0, 0.15 * height), "0.1 0.1 0.3"),
    ):
        yield f"      {visual(name, box(size), at, color)}"
    yield "    </link>"


def _leg(robot: Hexapod, leg: Leg) -> Iterator[str]:
    """Yield links and joints of a leg; in the frame of each link x points along the leg, y is level."""
    x, y = leg.at
    knee = -(robot.raised + pi / 2 - robot.leaning)
    chain = (
        # joint, where its link is in the one before, axis in the link, length of the link
        ("delta", f"{_(x)} {_(y)} 0 0 0 0", f"{leg.side} 0 0", 0.0),
        ("alpha", f"0 0 0 0 0 {_(leg.heading)}", f"0 0 {-leg.side}", robot.coxa),
        ("beta", f"{_(robot.coxa)} 0 0 0 {_(-robot.raised)} 0", "0 -1 0", robot.thigh),
        ("gamma", f"{_(robot.thigh)} 0 0 0 {_(-knee)} 0", "0 -1 0", robot.shin),
    )
    before = "body"
    for (joint, place, axis, length), limit, mass in zip(chain, robot.limits, robot.leg_mass, strict=True):
        link = f"{leg.name}_{joint}_link"
        yield f'    <link name="{link}">'
        yield f'      <pose relative_to="{before}">{place}</pose>'
        yield from _segment(robot, length, mass, is_shin=joint == "gamma")
        yield "    </link>"
        yield f'    <joint name="{leg.name}_{joint}" type="revolute">'
        yield f"      <parent>{before}</parent><child>{link}</child>"
        yield f"      <axis><xyz>{axis}</xyz><limit><lower>{_(-limit)}</lower><upper>{_(limit)}</upper>"
        yield f"        <effort>{_(robot.effort)}</effort></limit>"
        yield "        <dynamics><damping>0.1</damping></dynamics></axis>"
        yield "    </joint>"
        before = link


def _segment(robot: Hexapod, length: float, mass: float, *, is_shin: bool) -> Iterator[str]:
    """Yield the inertia, visual and collision of a part of a leg."""
    thick = robot.thick
    if not length:
        yield f"      {inertial(mass, (2 * thick,) * 3)}"
        yield f'      <visual name="hip">{ball(1.3 * thick)}{material(DARK)}</visual>'
        return
    yield f"      {inertial(mass, (length, 2 * thick, 2 * thick), length / 2)}"
    yield f"      {bar(length, 0.6 * thick if is_shin else thick, DARK if is_shin else ORANGE)}"
    if is_shin:
        foot = f"<pose>{_(length)} 0 0 0 0 0</pose>{ball(thick)}"
        yield f'      <visual name="foot">{foot}{material("0.1 0.1 0.1")}</visual>'
        yield f'      <collision name="foot">{foot}</collision>'


if __name__ == "__main__":
    print(sdf(Hexapod()), end="")
