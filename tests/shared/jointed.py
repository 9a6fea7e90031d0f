"""Models of a bob and the joints that hold it, as SDF, and what tests do with them."""

from __future__ import annotations

from pathlib import Path

from nrp_core.messages.base import Duration
from nrp_core.messages.geometry_msgs import Point, Vector3, Wrench
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.rigid import Vector
from nrp_core.scene.sdf import read_model
from nrp_core.world.world import World

GRAVITY, MASS, ARM, MOMENT = 9.8, 2.0, 0.5, 0.02
ROUND = MOMENT + MASS * ARM**2  # kg m^2 of the bob about its joint
FREE: Vector = (0.0, 0.0, 0.0)


def read(folder: Path, body: str) -> Model:
    """Read the contents of a <model>."""
    path = folder / "robot.sdf"
    path.write_text(f'<sdf version="1.11"><model name="robot">{body}</model></sdf>')
    return read_model(path)


def link(
    name: str,
    mass: float = MASS,
    moments: Vector = (MOMENT, MOMENT, MOMENT),
    com: Vector = FREE,
    at: Vector = FREE,
) -> str:
    xx, yy, zz = moments
    inertia = f"<inertia><ixx>{xx}</ixx><iyy>{yy}</iyy><izz>{zz}</izz></inertia>"
    place = f"<pose>{com[0]} {com[1]} {com[2]} 0 0 0</pose>"
    stands = f"<pose>{at[0]} {at[1]} {at[2]} 0 0 0</pose>"
    return f'<link name="{name}">{stands}<inertial><mass>{mass}</mass>{place}{inertia}</inertial></link>'


def joint(kind: str, more: str = "", *, name: str = "j", parent: str = "world", child: str = "bob") -> str:
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="{kind}">{ends}{more}</joint>'


def axis(xyz: str, more: str = "", *, tag: str = "axis") -> str:
    return f"<{tag}><xyz>{xyz}</xyz>{more}</{tag}>"


def limit(lower: float, upper: float) -> str:
    return f"<limit><lower>{lower}</lower><upper>{upper}</upper></limit>"


def controlled(*joints: tuple[str, str, str]) -> str:
    each = "".join(
        f'<controller joint_name="{name}"><type>{kind}</type>{gains}</controller>'
        for name, kind, gains in joints
    )
    return f'<plugin name="c" filename="generic_controller_plugin">{each}</plugin>'


def command(world: World, joint_name: str, kind: str, value: float) -> None:
    world.advertise(f"/robot/{joint_name}/cmd_{kind}").publish(Float64(value))


def push(
    world: World, name: str, torque: Vector = FREE, force: Vector = FREE, lasts_ns: int | None = None
) -> None:
    """Let a torque and a force act on a link, along the axes of the world."""
    load = Wrench(Vector3(*force), Vector3(*torque))
    lasts = Duration(-1) if lasts_ns is None else Duration(0, lasts_ns)
    world.call("/gazebo/apply_body_wrench", f"robot::{name}", "world", Point(), load, duration=lasts)


def told(world: World) -> tuple[dict[str, float], dict[str, float]]:
    """Return positions and velocities by name."""
    states = world.joint_states("robot")
    return (
        dict(zip(states.names, states.positions.tolist(), strict=True)),
        dict(zip(states.names, states.velocities.tolist(), strict=True)),
    )


def weightless(model: Model) -> Scene:
    return Scene((model,), gravity=FREE)


HANGING = link("bob", com=(0.0, 0.0, -ARM))
CROSS = axis("1 0 0") + axis("0 1 0", tag="axis2")
