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

SIDES = (("left", 1), ("right", -1))
PLACES = (("front", 1), ("middle", 0), ("rear", -1))
JOINTS = ("delta", "alpha", "beta", "gamma")

_CONTROLLER = "gz-sim-joint-position-controller-system"


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
            lines += _controller(robot, f"{leg.name}_{joint}")
    return "\n".join([*lines, "  </model>", "</sdf>", ""])


def _body(robot: Hexapod) -> Iterator[str]:
    length, width, height = robot.body
    size = f"{_(length)} {_(width)} {_(height)}"
    yield '    <link name="body">'
    yield f"      {_inertial(robot.mass, robot.body)}"
    yield f'      <collision name="body"><geometry><box><size>{size}</size></box></geometry></collision>'
    yield _box("hull", (length, width, 0.6 * height), (0, 0, 0), "0.85 0.45 0.10")
    yield _box("back", (0.8 * length, 0.7 * width, 0.4 * height), (-0.03, 0, 0.5 * height), "0.20 0.20 0.22")
    yield _box("head", (0.10, 0.6 * width, 0.5 * height), (0.54 * length, 0, 0.1 * height), "0.92 0.92 0.90")
    yield _box(
        "eyes", (0.01, 0.4 * width, 0.15 * height), (0.54 * length + 0.052, 0, 0.15 * height), "0.1 0.1 0.3"
    )
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
        yield f"      {_inertial(mass, (2 * thick,) * 3)}"
        ball = f"<geometry><sphere><radius>{_(1.3 * thick)}</radius></sphere></geometry>"
        yield f'      <visual name="hip">{ball}{_color("0.20 0.20 0.22")}</visual>'
        return
    yield f"      {_inertial(mass, (length, 2 * thick, 2 * thick), length / 2)}"
    pose = f"<pose>{_(length / 2)} 0 0 0 {_(pi / 2)} 0</pose>"
    radius = 0.6 * thick if is_shin else thick
    capsule = f"<capsule><radius>{_(radius)}</radius><length>{_(length)}</length></capsule>"
    color = _color("0.20 0.20 0.22" if is_shin else "0.85 0.45 0.10")
    yield f'      <visual name="bar">{pose}<geometry>{capsule}</geometry>{color}</visual>'
    if is_shin:
        ball = f"<geometry><sphere><radius>{_(thick)}</radius></sphere></geometry>"
        foot = f"<pose>{_(length)} 0 0 0 0 0</pose>{ball}"
        yield f'      <visual name="foot">{foot}{_color("0.1 0.1 0.1")}</visual>'
        yield f'      <collision name="foot">{foot}</collision>'


def _controller(robot: Hexapod, joint: str) -> Iterator[str]:
    yield f'    <plugin name="gz::sim::systems::JointPositionController" filename="{_CONTROLLER}">'
    yield f"      <joint_name>{joint}</joint_name><topic>{joint}/cmd_pos</topic>"
    yield f"      <p_gain>{_(robot.stiffness)}</p_gain><i_gain>0</i_gain><d_gain>{_(robot.damping)}</d_gain>"
    yield "      <initial_position>0</initial_position>"
    yield "    </plugin>"


def _inertial(mass: float, size: tuple[float, ...], x: float = 0.0) -> str:
    """Return the mass properties of a box about its centre."""
    a, b, c = (side * side for side in size)
    moments = zip(("ixx", "iyy", "izz"), (b + c, a + c, a + b), strict=True)
    inertia = "".join(f"<{axis}>{_(mass / 12 * squares)}</{axis}>" for axis, squares in moments)
    pose = f"<pose>{_(x)} 0 0 0 0 0</pose>" if x else ""
    return f"<inertial><mass>{_(mass)}</mass>{pose}<inertia>{inertia}</inertia></inertial>"


def _box(name: str, size: tuple[float, ...], at: tuple[float, ...], color: str) -> str:
    pose = f"<pose>{' '.join(map(_, at))} 0 0 0</pose>"
    box = f"<geometry><box><size>{' '.join(map(_, size))}</size></box></geometry>"
    return f'      <visual name="{name}">{pose}{box}{_color(color)}</visual>'


def _color(rgb: str) -> str:
    return f"<material><diffuse>{rgb} 1</diffuse></material>"


def _(number: float) -> str:
    """Return a number with at most six significant digits."""
    return f"{number:.6g}"


if __name__ == "__main__":
    print(sdf(Hexapod()), end="")
