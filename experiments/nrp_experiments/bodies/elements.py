"""Elements of SDF as text, for the bodies that are made from their dimensions. Lengths in m, masses in kg."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

SMALLEST_INERTIA = 1.5e-14
"""kg m^2; physics engines refuse less. It exceeds that of the smallest parts of a fly's legs."""


def number(value: float) -> str:
    """Return a number with at most six significant digits."""
    return f"{value:.6g}"


def numbers(values: Sequence[float]) -> str:
    """Return numbers with spaces between them."""
    return " ".join(map(number, values))


def inertial(mass: float, size: Sequence[float], x: float = 0.0) -> str:
    """Return the mass properties of a box, centred at ``x``."""
    a, b, c = (side * side for side in size)
    moments = zip(("ixx", "iyy", "izz"), (b + c, a + c, a + b), strict=True)
    inertia = "".join(
        f"<{axis}>{number(max(mass / 12 * squares, SMALLEST_INERTIA))}</{axis}>" for axis, squares in moments
    )
    pose = f"<pose>{number(x)} 0 0 0 0 0</pose>" if x else ""
    return f"<inertial><mass>{number(mass)}</mass>{pose}<inertia>{inertia}</inertia></inertial>"


def box(size: Sequence[float]) -> str:
    """Return the geometry of a box."""
    return f"<geometry><box><size>{numbers(size)}</size></box></geometry>"


def ball(radius: float) -> str:
    """Return the geometry of a ball."""
    return f"<geometry><sphere><radius>{number(radius)}</radius></sphere></geometry>"


def bar(length: float, radius: float, color: str) -> str:
    """Return the visual of a bar along x, from the origin on."""
    pose = f"<pose>{number(length / 2)} 0 0 0 {number(pi / 2)} 0</pose>"
    capsule = f"<capsule><radius>{number(radius)}</radius><length>{number(length)}</length></capsule>"
    return f'<visual name="bar">{pose}<geometry>{capsule}</geometry>{material(color)}</visual>'


def visual(name: str, geometry: str, at: Sequence[float], color: str) -> str:
    """Return a visual; ``at`` is a position and, after it, the roll, pitch and yaw, if any."""
    pose = numbers([*at, *[0.0] * (6 - len(at))])
    return f'<visual name="{name}"><pose>{pose}</pose>{geometry}{material(color)}</visual>'


def material(rgb: str) -> str:
    """Return a color of a visual."""
    return f"<material><diffuse>{rgb} 1</diffuse></material>"


def position_controller(joint: str, p: float, d: float) -> str:
    """Return a controller that moves a joint to the commands on ``<joint>/cmd_pos``, from 0 on."""
    return (
        '<plugin name="gz::sim::systems::JointPositionController" '
        'filename="gz-sim-joint-position-controller-system">\n'
        f"      <joint_name>{joint}</joint_name><topic>{joint}/cmd_pos</topic>\n"
        f"      <p_gain>{number(p)}</p_gain><i_gain>0</i_gain><d_gain>{number(d)}</d_gain>\n"
        "      <initial_position>0</initial_position>\n"
        "    </plugin>"
    )
