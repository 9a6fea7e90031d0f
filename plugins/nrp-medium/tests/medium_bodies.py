"""Bodies of tests, as SDF, with the numbers that their formulas need."""

from __future__ import annotations

from collections.abc import Sequence

from nrp_core.world.world import World

G = 9.8
SYSTEM = "gz::sim::systems"
WATER = f'<plugin name="{SYSTEM}::Buoyancy" filename="gz-sim-buoyancy-system">{{}}</plugin>'


def link(
    name: str,
    mass: float,
    moments: Sequence[float],
    *,
    at: str = "0 0 0 0 0 0",
    com: str = "0 0 0 0 0 0",
    shape: str = "",
) -> str:
    xx, yy, zz = moments
    solid = f'<collision name="c">{shape}</collision>' if shape else ""
    return (
        f'<link name="{name}"><pose>{at}</pose><inertial><pose>{com}</pose><mass>{mass}</mass><inertia>'
        f"<ixx>{xx}</ixx><iyy>{yy}</iyy><izz>{zz}</izz></inertia></inertial>{solid}</link>"
    )


def box(x: float, y: float, z: float) -> str:
    return f"<geometry><box><size>{x} {y} {z}</size></box></geometry>"


def model(text: str, at: str = "0 0 0 0 0 0", name: str = "body") -> str:
    return f'<model name="{name}"><pose>{at}</pose>{text}</model>'


def plugin(kind: str, text: str, name: str = "") -> str:
    return f'<plugin name="{name or f"{SYSTEM}::{kind}"}" filename="{kind}">{text}</plugin>'


def run(world: World, seconds: float) -> None:
    world.run_until(world.now_ns + round(seconds * 1e9))


MOTOR, MOMENT, ROTOR_MASS, FRAME_MASS, ARM = 8.54858e-06, 0.016, 0.016, 2.0, 0.174
"""The constants of PX4's x500."""
ROTORS = ((1, -1, "ccw"), (-1, 1, "ccw"), (1, 1, "cw"), (-1, -1, "cw"))


def quadrotor(at: str = "0 0 5 0 0 0", name: str = "quad") -> str:
    """Return a quadrotor with the masses, arms and motors of PX4's x500."""
    parts = [link("base", FRAME_MASS, (0.0217, 0.0217, 0.04))]
    for number, (x, y, turning) in enumerate(ROTORS):
        place = f"{ARM * x} {ARM * y} 0.06 0 0 0"
        parts.append(link(f"rotor_{number}", ROTOR_MASS, (4e-6, 2.6e-5, 2.6e-5), at=place))
        parts.append(
            f'<joint name="rotor_{number}_joint" type="revolute"><parent>base</parent>'
            f"<child>rotor_{number}</child><axis><xyz>0 0 1</xyz></axis></joint>"
        )
        parts.append(
            plugin(
                "MulticopterMotorModel",
                f"<jointName>rotor_{number}_joint</jointName><linkName>rotor_{number}</linkName>"
                f"<turningDirection>{turning}</turningDirection><motorConstant>{MOTOR}</motorConstant>"
                f"<momentConstant>{MOMENT}</momentConstant><maxRotVelocity>1000</maxRotVelocity>"
                "<timeConstantUp>0.0125</timeConstantUp><timeConstantDown>0.025</timeConstantDown>"
                "<rotorDragCoefficient>8.06428e-05</rotorDragCoefficient>"
                f"<commandSubTopic>command/motor_speed</commandSubTopic><actuator_number>{number}</actuator_number>",
            )
        )
    return model("".join(parts), at, name)
