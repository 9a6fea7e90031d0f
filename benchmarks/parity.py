"""Compare the engines with each other and with closed forms: drives, slopes and loads, physics, cameras.

Prints tables in Markdown; `docs/reference/parity.md` shows them. Poses are compared after the same commands,
images from the same places; the seeds determine everything.

    python benchmarks/parity.py
    python benchmarks/parity.py --seeds 3 --only drives cameras
    python benchmarks/parity.py --engines mujoco pybullet gazebo
    python benchmarks/parity.py --engines gazebo --only plugins
    python benchmarks/parity.py --only robots --turtlebot3 turtlebot3_burger/model.sdf

The quadruped is the A1 of ``pybullet_data``.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from importlib.resources import files
from importlib.util import find_spec
from itertools import combinations
from math import cos, degrees, exp, hypot, inf, pi, radians, remainder, sin, sqrt, tau
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from conditions import print_conditions
from robots import stood

from nrp_core.dsl.tf_lib import detect_red
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController, Pid
from nrp_core.scene.model import (
    Box,
    Collision,
    Geometry,
    Inertial,
    Joint,
    Link,
    Model,
    Plane,
    Scene,
    Sphere,
)
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.world.backends import worlds
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.render.cameras import REALISTIC
from nrp_core.world.world import World

PARTS = ("drives", "wheels", "plugins", "loads", "physics", "robots", "cameras")
ENGINES = ("mujoco", "pybullet")
STEP_NS = 20_000_000
G = 9.8
SHIPPED = Path(str(files("nrp_experiments")))
ROBOTS = {"Husky": "braitenberg_husky/husky.sdf", "Pioneer": "bodies/pioneer.sdf"}
GAZEBO = "gazebo"
PLUGIN = (
    '<plugin name="drive" filename="libDiffDrivePlugin.so"><left_joint>left_wheel_joint</left_joint>'
    "<right_joint>right_wheel_joint</right_joint><torque>5</torque></plugin>"
)
"""The drive of Gazebo itself, for the Pioneer."""

Commands = Sequence[tuple[float, float]]
Measure = Callable[[str], float]


def table(title: str, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print one table."""
    print(f"\n## {title}\n")
    for row in (header, ["---"] * len(header), *rows):
        print(
            "| " + " | ".join(f"{cell:.2g}" if isinstance(cell, float) else str(cell) for cell in row) + " |"
        )


@contextmanager
def opened(engine: str, scene: Scene, **options: Any) -> Iterator[World]:
    backend = worlds().load(engine)
    with backend.open(scene, seed=1, options=backend.options(**options)) as world:
        yield world


def scene(*models: Model, gravity: tuple[float, float, float] = (0.0, 0.0, -G)) -> Scene:
    return Scene(models, gravity=gravity)


def prop(
    name: str,
    shape: Geometry,
    pose: Pose = Pose(),
    mass: float = 0.0,
    friction: float = 1.0,
    moment: float = 0.0,
) -> Model:
    """Return one link, static unless it has a mass."""
    moment = moment or 0.01 * mass
    inertial = Inertial(mass, inertia=(moment, moment, moment, 0.0, 0.0, 0.0)) if mass else None
    link = Link("link", inertial=inertial, collisions=(Collision("c", shape, friction=friction),))
    return Model(name, (link,), pose=pose, static=not mass)


FLOOR = prop("floor", Plane((60.0, 60.0)))


def robot(name: str, pose: Pose = Pose()) -> Model:
    """Return a shipped robot called ``robot``, standing at a pose on the ground."""
    model = read_model(SHIPPED / ROBOTS[name])
    standing = Pose((0.0, 0.0, 0.14)) if name == "Husky" else model.pose
    return read_model(SHIPPED / ROBOTS[name], name="robot", pose=pose @ standing)


def advance(world: World, seconds: float) -> None:
    for _ in range(round(seconds * 1e9 / STEP_NS)):
        world.run_until(world.now_ns + STEP_NS)


def with_own_plugin(folder: Path) -> Model:
    """Return the Pioneer with the drive of Gazebo itself, from a file that Gazebo reads."""
    text = (SHIPPED / ROBOTS["Pioneer"]).read_text().replace('version="1.9"', 'version="1.6"')
    before, _, rest = text.rpartition("    <plugin ")
    file = folder / "pioneer.sdf"
    file.write_text(f"{before}{PLUGIN}{rest.partition('</plugin>')[2]}")
    return read_model(file, name="robot")


def driven(world: World, commands: Commands, seconds: float = 1.0) -> Pose:
    """Let the robot settle, give it each command for some time, and return its trajectory from the start."""
    topics = ("/robot/cmd_vel", "/husky/cmd_vel", "/robot/vel_cmd")
    topic = next(name for name in topics if name in world.topics)
    says = world.advertise(topic)
    advance(world, 0.5)
    start = world.model_motion("robot").pose
    for forward, turn in commands:
        for _ in range(round(seconds * 1e9 / STEP_NS)):
            says.publish(Twist(Vector3(forward), Vector3(0.0, 0.0, turn)))
            world.run_until(world.now_ns + STEP_NS)
    return start.inverse() @ world.model_motion("robot").pose


def ideal(commands: Commands, seconds: float = 1.0) -> Pose:
    """Return the final pose of the unicycle."""
    place, yaw = 0j, 0.0
    for v, w in commands:
        chord = v * seconds * np.sinc(w * seconds / tau)  # sin(x) / x at x = w t / 2
        place += chord * np.exp(1j * (yaw + w * seconds / 2))
        yaw += w * seconds
    return Pose.from_rpy((place.real, place.imag, 0.0), 0.0, 0.0, yaw)


def apart(a: Pose, b: Pose) -> tuple[float, float]:
    """Return how far two poses are apart on the ground: mm, and degrees of yaw."""
    distance = hypot(a.position[0] - b.position[0], a.position[1] - b.position[1])
    return 1e3 * distance, abs(degrees(remainder(a.yaw - b.yaw, tau)))


def drives(seeds: int, engines: Sequence[str]) -> None:
    rows = []
    for name in ROBOTS:
        far: dict[tuple[str, str], list[tuple[float, float]]] = {}
        for seed in range(seeds):
            random = np.random.default_rng(seed)
            commands = list(zip(random.uniform(-1, 1, 30), random.uniform(-2, 2, 30), strict=True))
            ends = {"unicycle": ideal(commands)}
            for engine in engines:
                with opened(engine, scene(FLOOR, robot(name))) as world:
                    ends[engine] = driven(world, commands)
            for pair in combinations(ends, 2):
                far.setdefault(pair, []).append(apart(*(ends[each] for each in pair)))
        for pair, all_far in far.items():
            rows.append((name, " and ".join(pair), *np.max(all_far, axis=0).tolist()))
    title = f"30 s of random commands: greatest distance of end poses over {seeds} seeds"
    table(title, ("robot", "between", "mm", "degrees"), rows)


def wheels(engines: Sequence[str]) -> None:
    """Compare robots on wheels with the unicycle, the Husky also as its maker calibrates the real one."""
    commands = {"0.5 m/s": (0.5, 0.0), "0.5 rad/s": (0.0, 0.5), "both": (0.5, 0.5)}
    rows = []
    for name, widened in (("Pioneer", 1.0), ("Husky", 1.0), ("Husky", 1.875)):
        model = robot(name)
        (drive,) = model.drives
        assert isinstance(drive, WheelDrive)
        model = replace(model, drives=(replace(drive, separation=widened * drive.separation),))
        for engine in engines:
            errors = []
            for command in commands.values():
                with opened(engine, scene(FLOOR, model), drive="physical") as world:
                    off = ideal([command] * 2).inverse() @ driven(world, [command] * 2)
                away_cm = 100 * hypot(*off.position[:2])
                errors.append(f"{away_cm:.1f} cm, {degrees(off.yaw):.1f} degrees")
            rows.append((f"{name}, separation x {widened:g}", engine, *errors))
    table("Off the unicycle after 2 s on wheels (`drive: physical`)", ("robot", "engine", *commands), rows)


def plugins(seeds: int, engines: Sequence[str]) -> None:
    """Compare Gazebo's own drive with ours, by the same file and commands."""
    if GAZEBO not in engines:
        return
    rows: list[tuple[object, ...]] = []
    steady = {
        "1 m/s": (1.0, 0.0),
        "-1 m/s": (-1.0, 0.0),
        "1 rad/s": (0.0, 1.0),
        "0.5 m/s, 0.5 rad/s": (0.5, 0.5),
    }
    with TemporaryDirectory() as folder:
        model = with_own_plugin(Path(folder))

        def end(drive: str, commands: Commands) -> Pose:
            with opened(GAZEBO, scene(FLOOR, model), drive=drive) as world:
                return driven(world, commands)

        rows.extend(
            (f"2 s of {said}", drive, *apart(end(drive, [command] * 2), ideal([command] * 2)))
            for said, command in steady.items()
            for drive in ("planar", "plugin")
        )
        far: dict[str, list[tuple[float, float]]] = {}
        for seed in range(seeds):
            random = np.random.default_rng(seed)
            commands = list(zip(random.uniform(-1, 1, 30), random.uniform(-2, 2, 30), strict=True))
            ours, theirs = end("planar", commands), end("plugin", commands)
            far.setdefault("planar", []).append(apart(ours, ideal(commands)))
            far.setdefault("plugin", []).append(apart(theirs, ideal(commands)))
            far.setdefault("plugin, off planar", []).append(apart(theirs, ours))
        for drive, ends in far.items():
            rows.append(("30 s of random commands", drive, *np.max(ends, axis=0).tolist()))
    title = f"Gazebo's own drive: the Pioneer off the unicycle, greatest of {seeds} seeds"
    table(title, ("commands", "drive", "mm", "degrees"), rows)


def tilted(angle: float, friction: float = 1.0) -> tuple[Model, Pose]:
    """Return a slope that rises along x, and its frame at the origin."""
    frame = Pose.from_rpy((0.0, 0.0, 0.0), 0.0, -radians(angle), 0.0)
    return prop("slope", Box((40.0, 40.0, 1.0)), frame @ Pose((0.0, 0.0, -0.5)), friction=friction), frame


def on_slope(angle: float, commands: Commands, engine: str) -> Pose:
    ground, frame = tilted(angle)
    with opened(engine, scene(ground, robot("Husky", frame))) as world:
        return driven(world, commands)


def climbed(angle: float, speed: float, engine: str) -> float:
    return on_slope(angle, [(speed, 0.0)] * 4, engine).position[0]


def crept(angle: float, engine: str) -> float:
    return 1e3 * float(np.linalg.norm(on_slope(angle, [(0.0, 0.0)] * 10, engine).position)) / 10


def wandered(angle: float, engine: str) -> float:
    return 1e3 * float(np.linalg.norm(on_slope(angle, [(0.0, 1.0)] * 6, engine).position))


def loaded(mass: float, engine: str) -> float:
    """Return how far from the unicycle the Husky ends with a crate on its back, mm; infinite without it."""
    crate = prop("crate", Box((0.4, 0.4, 0.2)), Pose((-0.1, 0.0, 0.7)), mass, moment=mass * 0.02)
    commands = [(0.4, 0.5), (0.4, -0.8), (0.0, 1.0), (-0.3, 0.2), (0.5, 0.0)]
    with opened(engine, scene(FLOOR, robot("Husky"), crate)) as world:
        end = driven(world, commands)
        carried = world.model_motion("crate").pose.position[2] > 0.3
    return apart(end, ideal(commands))[0] if carried else inf


def pushed(mass: float, what: str, engine: str) -> float:
    crate = prop("crate", Box((0.5, 0.5, 0.5)), Pose((0.9, 0.0, 0.25)), mass, 0.5, mass * 0.04)
    with opened(engine, scene(FLOOR, robot("Husky"), crate)) as world:
        way = driven(world, [(0.5, 0.0)] * 4).position[0]
        return way if what == "robot" else world.model_motion("crate").pose.position[0] - 0.9


def loads(engines: Sequence[str]) -> None:
    cases: list[tuple[str, str, Measure]] = [
        *(
            (f"up {angle:.0f} degrees, 4 s at 0.5 m/s: way, m", "2", partial(climbed, angle, 0.5))
            for angle in (5.0, 10.0, 15.0, 20.0)
        ),
        ("down 15 degrees, 4 s at -0.5 m/s: way, m", "-2", partial(climbed, 15.0, -0.5)),
        ("standing on 15 degrees: creep, mm/s", "0", partial(crept, 15.0)),
        ("turning on 15 degrees, 6 rad: wander, mm", "0", partial(wandered, 15.0)),
        *(
            (f"a crate of {mass:.0f} kg on its back, 5 s: off the unicycle, mm", "0", partial(loaded, mass))
            for mass in (5.0, 20.0, 40.0)
        ),
        *(
            (
                f"pushing {mass:.0f} kg for 4 s at 0.5 m/s: way of the {what}, m",
                way,
                partial(pushed, mass, what),
            )
            for mass in (3.0, 20.0, 60.0)
            for what, way in (("robot", "2"), ("crate", "1.85"))
        ),
    ]
    rows = [
        (said, wanted, *(f"{measure(engine):.3g}" for engine in engines)) for said, wanted, measure in cases
    ]
    table("The Husky on slopes, with a load, and pushing", ("what", "ideal", *engines), rows)


def fallen(engine: str) -> float:
    with opened(engine, scene(prop("ball", Sphere(0.1), mass=1.0))) as world:
        advance(world, 1.0)
        return -world.model_motion("ball").pose.position[2]


def hinged(joint: Joint, com: tuple[float, float, float], control: JointController | None = None) -> Model:
    """Return a bob of 2 kg with moments of 0.02 kg m^2, on a joint to the world."""
    bob = Link("bob", inertial=Inertial(2.0, Pose(com), (0.02, 0.02, 0.02, 0.0, 0.0, 0.0)))
    controllers = (control,) if control else ()
    return Model("bob", (bob,), (joint,), pose=Pose((0.0, 0.0, 2.0)), controllers=controllers)


def period(engine: str) -> float:
    """Return the period of a pendulum let go at 0.1 rad, from the times at its lowest point."""
    joint = Joint("j", "continuous", "world", "bob", axis=(0.0, 1.0, 0.0))
    crossings: list[float] = []
    with opened(engine, scene(hinged(joint, (0.5 * sin(0.1), 0.0, -0.5 * cos(0.1))))) as world:
        before = -0.1
        while len(crossings) < 5:
            world.run_until(world.now_ns + 2_000_000)
            now = float(world.joint_states("bob").positions[0]) - 0.1
            if before * now < 0:
                crossings.append(world.now_ns / 1e9 - 2e-3 * now / (now - before))
            before = now
    return (crossings[4] - crossings[0]) / 2


def down_a_slope(
    shape: Geometry,
    height: float,
    angle: float,
    friction: float,
    moment: float,
    engine: str,
    *,
    below: float = 1.0,
) -> float:
    """Return the speed after 1 s; the friction of the slope is ``below``."""
    ground, frame = tilted(angle, below)
    body = prop("body", shape, frame @ Pose((0.0, 0.0, height)), 1.0, friction, moment)
    with opened(engine, scene(ground, body)) as world:
        advance(world, 1.0)
        return float(np.linalg.norm(world.model_motion("body").linear))


def stacked(engine: str) -> float:
    boxes = [prop(f"b{i}", Box((0.2, 0.2, 0.2)), Pose((0.0, 0.0, 0.1 + 0.2 * i)), 1.0) for i in range(5)]
    with opened(engine, scene(FLOOR, *boxes)) as world:
        advance(world, 3.0)
        return world.model_motion("b4").pose.position[2]


def stopped(engine: str) -> float:
    joint = Joint("j", "revolute", "world", "bob", axis=(0.0, 1.0, 0.0), lower=-0.5, upper=0.4)
    with opened(engine, scene(hinged(joint, (0.5, 0.0, 0.0)))) as world:
        advance(world, 3.0)
        return float(world.joint_states("bob").positions[0])


STEP_RESPONSE = {"mass": 0.02 + 2.0 * 0.25, "stiffness": 30.0, "damping": 2.0}


def step_response(t: float) -> float:
    """Return the angle at ``t`` after a step of 1 rad, of a mass on a spring with a damper."""
    m, k, d = STEP_RESPONSE.values()
    decay = d / (2 * m)
    omega = sqrt(k / m - decay**2)
    return 1 - exp(-decay * t) * (cos(omega * t) + decay / omega * sin(omega * t))


def stepped(engine: str) -> float:
    """Return the greatest distance from the closed form in 2 s."""
    gains = Pid(STEP_RESPONSE["stiffness"], 0.0, STEP_RESPONSE["damping"])
    joint = Joint("j", "continuous", "world", "bob", axis=(0.0, 1.0, 0.0))
    model = hinged(joint, (0.5, 0.0, 0.0), JointController("j", "position", "/bob/cmd_pos", gains))
    off = 0.0
    with opened(engine, scene(model, gravity=(0.0, 0.0, 0.0))) as world:
        world.advertise("/bob/cmd_pos").publish(Float64(1.0))
        while world.now_ns < 2_000_000_000:
            world.run_until(world.now_ns + STEP_NS)
            angle = float(world.joint_states("bob").positions[0])
            off = max(off, abs(angle - step_response(world.now_ns / 1e9)))
    return off


def physics(engines: Sequence[str]) -> None:
    slide, steep, roll = radians(30.0), radians(20.0), radians(10.0)
    swing = tau * sqrt((0.02 + 2.0 * 0.25) / (2.0 * G * 0.5)) * (1 + 0.1**2 / 16)
    ball, box = Sphere(0.2), Box((0.4, 0.4, 0.2))
    cases: list[tuple[str, float, Measure]] = [
        ("free fall in 1 s, m", G / 2, fallen),
        ("period of a pendulum, s", swing, period),
        ("a ball rolls down 10 degrees: speed after 1 s, m/s", 5 / 7 * G * sin(roll),
         partial(down_a_slope, ball, 0.2, 10.0, 1.0, 0.4 * 0.04)),
        ("a box slides down 30 degrees, friction 0.3: speed after 1 s, m/s",
         G * (sin(slide) - 0.3 * cos(slide)),
         partial(down_a_slope, box, 0.1, 30.0, 0.3, 0.02)),
        ("a box slides down 20 degrees, friction 0.2 on 0.5: speed after 1 s, m/s",
         G * (sin(steep) - 0.2 * cos(steep)),
         partial(down_a_slope, box, 0.1, 20.0, 0.2, 0.02, below=0.5)),
        ("a box slides down 20 degrees, friction 0.5 on 0.2: speed after 1 s, m/s",
         G * (sin(steep) - 0.2 * cos(steep)),
         partial(down_a_slope, box, 0.1, 20.0, 0.5, 0.02, below=0.2)),
        ("five boxes on each other after 3 s: height of the uppermost, m", 0.9, stacked),
        ("a heavy bob on the limit of its joint, rad", 0.4, stopped),
        ("step response of a position controller: off the closed form in 2 s, rad", 0.0, stepped),
    ]  # fmt: skip
    rows = [
        (said, f"{wanted:.4g}", *(f"{measure(engine):.4g}" for engine in engines))
        for said, wanted, measure in cases
    ]
    table("Closed forms, physics steps of 2 ms", ("what", "closed form", *engines), rows)


def gripper() -> Model:
    """Return a hand on a lift: two fingers of 2 cm that close by up to 10 cm, each with 20 N."""
    moment = (0.001, 0.001, 0.001, 0.0, 0.0, 0.0)
    shape = Collision("c", Box((0.04, 0.02, 0.06)), friction=0.6)
    hand = Link("hand", Pose((0.0, 0.0, 0.3)), Inertial(1.0, inertia=moment))
    fingers = [
        Link(name, Pose((0.0, y, 0.1)), Inertial(0.1, inertia=moment), collisions=(shape,))
        for name, y in (("left", 0.11), ("right", -0.11))
    ]
    lift = Joint("lift", "prismatic", "world", "hand", hand.pose, (0.0, 0.0, 1.0), lower=0.0, upper=0.3)
    closing = [
        Joint(each.name, "prismatic", "hand", each.name, each.pose, (0.0, sign, 0.0), 0.0, 0.1, effort=20.0)
        for each, sign in zip(fingers, (-1.0, 1.0), strict=True)
    ]
    controllers = [
        JointController(name, "position", f"/hand/{name}", None) for name in ("lift", "left", "right")
    ]
    return Model("hand", (hand, *fingers), (lift, *closing), controllers=tuple(controllers))


def slipped(mass: float, engine: str) -> float:
    """Return by how much a box slips in the fingers while it is lifted by 0.2 m in 2 s and held, mm."""
    box = prop("box", Box((0.1, 0.1, 0.1)), Pose((0.0, 0.0, 0.1)), mass, 0.6)
    bench = prop("bench", Box((1.0, 1.0, 0.05)), Pose((0.0, 0.0, 0.025)))
    with opened(engine, scene(bench, gripper(), box)) as world:
        for finger in ("left", "right"):
            world.advertise(f"/hand/{finger}").publish(Float64(0.08))
        advance(world, 1.0)
        before = world.model_motion("box").pose.position[2]
        lift = world.advertise("/hand/lift")
        for number in range(1, 101):
            lift.publish(Float64(0.002 * number))
            advance(world, 0.02)
        advance(world, 1.0)
        states = world.joint_states("hand")
        lifted = float(states.positions[states.names.index("lift")])
        return 1e3 * (before + lifted - world.model_motion("box").pose.position[2])


def crept_out(engine: str, **options: float) -> float:
    """Return by how much a box of 0.2 kg slips in 10 s between two fingers that press with 2.5 N each, mm."""
    moment, joints = (0.001, 0.001, 0.001, 0.0, 0.0, 0.0), []
    base, controllers = Link("base", inertial=Inertial(5.0)), []
    fingers = [
        Link(name, Pose((0.0, y, 1.0)), Inertial(0.1, inertia=moment),
             collisions=(Collision("c", Box((0.1, 0.02, 0.1)), friction=0.5),))
        for name, y in (("left", 0.0601), ("right", -0.0601))
    ]  # fmt: skip
    for each, sign in zip(fingers, (-1.0, 1.0), strict=True):
        axis = (0.0, sign, 0.0)
        joints.append(Joint(each.name, "prismatic", "base", each.name, each.pose, axis, -0.1, 0.1))
        controllers.append(JointController(each.name, "effort", f"/hand/{each.name}", None))
    fixed = Joint("fixed", "fixed", "world", "base")
    hand = Model("hand", (base, *fingers), (fixed, *joints), controllers=tuple(controllers))
    box = prop("box", Box((0.1, 0.1, 0.08)), Pose((0.0, 0.0, 1.0)), 0.2, 0.5, 0.0005)
    with opened(engine, scene(hand, box), **options) as world:
        for finger in ("left", "right"):
            world.advertise(f"/hand/{finger}").publish(Float64(2.5))
        advance(world, 1.0)
        before = world.model_motion("box").pose.position[2]
        advance(world, 10.0)
        return 1e3 * (before - world.model_motion("box").pose.position[2])


def rolled(file: Path, command: tuple[float, float], drive: str, engine: str) -> str:
    """Return the way (m) and the turn (degrees) of a robot in 4 s of a command."""
    with opened(engine, scene(FLOOR, read_model(file, name="robot")), drive=drive) as world:
        end = driven(world, [command] * 4)
    return f"{end.position[0]:.3f}, {degrees(end.yaw):.1f}"


def robots(turtlebot3: Path | None, engines: Sequence[str]) -> None:
    rows: list[tuple[str, ...]] = [
        (f"a hand lifts a box of {mass:g} kg by 0.2 m in 2 s: slip, mm", "0",
         *(f"{slipped(mass, engine):.2g}" for engine in engines))
        for mass in (0.1, 0.5, 1.5)
    ]  # fmt: skip
    said = "two fingers hold 0.2 kg with 2.5 N each for 10 s: slip, mm"
    rows.append((said, "0", *(f"{crept_out(engine):.2g}" for engine in engines)))
    firm = f"{crept_out('mujoco', impratio=100.0):.2g}"
    rows.append((f"{said}, `impratio: 100`", "0", *(firm if each == "mujoco" else "-" for each in engines)))
    for drive in ("planar", "physical") if turtlebot3 else ():
        assert turtlebot3 is not None
        for command, ideal_end in (((0.2, 0.0), "0.800, 0.0"), ((0.0, 0.5), "0.000, 114.6")):
            said = f"TurtleBot3 (`{drive}`), 4 s of {command[0]:g} m/s and {command[1]:g} rad/s: m, degrees"
            ends = [rolled(turtlebot3, command, drive, engine) for engine in engines]
            rows.append((said, ideal_end, *ends))
    data = find_spec("pybullet_data")
    if data is not None and data.origin is not None:
        a1 = read_model(Path(data.origin).parent / "a1/a1.urdf", name="robot")
        said = "A1 holds its joints for 2 s: height, m, and tilt, degrees"
        rows.append((said, "-", *(stood(a1, engine) for engine in engines)))
    table("Robots", ("what", "ideal", *engines), rows)


REFERENCES = {REALISTIC: f"mujoco {REALISTIC}"}
"""What else than the flat images of MuJoCo's raster a renderer's are compared with."""


def views(engine: str, renderer: str, scale: float) -> list[np.ndarray[Any, Any]]:
    """Return what the Husky sees in the shipped room, one screen red, from twelve places."""
    room = read_scene(SHIPPED / "braitenberg_husky/room.sdf")
    images = []
    random = np.random.default_rng(0)
    for k in range(12):
        x, y = random.uniform(-1.2, 1.2, 2)
        place = Pose.from_rpy((x, y, 0.0), 0.0, 0.0, k * pi / 6)
        with opened(
            engine, room.with_model(robot("Husky", place)), renderer=renderer, image_scale=scale
        ) as world:
            world.engine.set_color("left_vr_screen/body/screen_glass", (1.0, 0.0, 0.0, 1.0))
            images.append(world.engine.render("robot", "eye_vision_camera", "camera"))
    return images


def red(image: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    height, width, _ = image.shape
    shares = detect_red(Image(height=height, width=width, encoding="rgb8", step=3 * width, data=image))
    return np.array([shares.left, shares.right])


def cameras(engines: Sequence[str]) -> None:
    rows = []
    for scale in (1.0, 0.2):
        seen = {}
        for engine in engines:
            backend = worlds().load(engine)
            for renderer in backend.capabilities(backend.options()).renderers:
                seen[f"{engine} {renderer}"] = views(engine, renderer, scale)
        for name, images in seen.items():
            reference = REFERENCES.get(name.split()[1], "mujoco raster")
            if name == reference:
                continue
            pairs = list(zip(seen[reference], images, strict=True))
            equal = [100 * float((a == b).all(axis=2).mean()) for a, b in pairs]
            reds = max(float(abs(red(a) - red(b)).max()) for a, b in pairs)
            size = f"{320 * scale:.0f}x{240 * scale:.0f}"
            rows.append((size, name, reference, f"{min(equal):.2f}", f"{np.mean(equal):.2f}", f"{reds:.4f}"))
    header = (
        "image",
        "renderer",
        "beside",
        "equal pixels, least %",
        "mean %",
        "`detect_red`, greatest difference",
    )
    table("Twelve views of the shipped room", header, rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10, help="of the random drives")
    parser.add_argument("--engines", nargs="+", default=ENGINES, help="world backends, mujoco first")
    parser.add_argument("--turtlebot3", type=Path, help="its file, of turtlebot3_simulations")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    arguments = parser.parse_args()
    print_conditions()
    measures: tuple[Callable[[Sequence[str]], object], ...] = (
        partial(drives, arguments.seeds), wheels, partial(plugins, arguments.seeds), loads, physics,
        partial(robots, arguments.turtlebot3), cameras,
    )  # fmt: skip
    for name, measure in zip(PARTS, measures, strict=True):
        if name in arguments.only:
            measure(arguments.engines)


if __name__ == "__main__":
    main()
