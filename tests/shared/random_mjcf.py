"""Random MJCF models: bodies, sites, tendons, constraints, actuators and sensors, over included files.

A model is drawn with Python's :class:`random.Random`. Its settings are in files that the main file includes:
the compiler and some default classes in one, a class inside a class in another, and a body in a third one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import degrees
from pathlib import Path
from random import Random

import numpy as np

from nrp_core.scene.meshes.stl import write_stl

WEDGE = 0.1 * np.array([
    [[0, 0, 0], [0, 1, 0], [2, 0, 0]], [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
    [[0, 0, 0], [2, 0, 0], [0, 0, 1]], [[2, 0, 0], [0, 1, 0], [0, 0, 1]],
], float)  # fmt: skip
"""A tetrahedron."""
_COMPILER: dict[str, tuple[str, ...]] = {
    "autolimits": ("true", "false"), "eulerseq": ("xyz", "ZYX", "yxz", "XzX"),
    "balanceinertia": ("true", "false"), "boundmass": ("0.05", "0"), "boundinertia": ("0.002", "0"),
    "inertiafromgeom": ("auto", "true", "false"), "inertiagrouprange": ("0 1", "1 3", "0 5"),
    "settotalmass": ("3", "-1"), "fusestatic": ("true", "false"), "alignfree": ("true", "false"),
    "discardvisual": ("true", "false"), "strippath": ("true", "false"), "fitaabb": ("true", "false"),
    "saveinertial": ("true", "false"), "usethread": ("false",),
}  # fmt: skip
"""Values of the compiler's attributes; ``angle`` and ``meshdir`` are always drawn."""
_OTHER_COMPILER = ("angle", "assetdir", "conflict", "coordinate", "meshdir", "passthrough", "savecanonical",
                   "savecompiled", "texturedir")  # fmt: skip
COMPILER = (*_COMPILER, *_OTHER_COMPILER)
"""Attributes of the compiler that models have, or that concern images and how MuJoCo saves a file."""


class RandomModel:
    """A random model.

    Args:
        seed: which one.
        joined: whether there are equality constraints. If not, bodies may be fixed to others, which
            are one body in a scene, and on another body constraints are a little softer.
        touching: whether some shapes touch each other and the hills of a height field below them.

    Attributes:
        files: the texts by name; the main one is ``robot.xml``.
        controls: the control of each actuator by its name.
        drawn: the attributes of the compiler.
    """

    def __init__(self, seed: int, *, joined: bool, touching: bool = False) -> None:
        self._random = Random(seed)
        self._joined, self._touching = joined, touching
        self._bodies: list[str] = []
        self._sites: list[str] = []
        self._inner = 0
        self._joints: list[str] = []
        self._balls = 0
        self._geoms: list[str] = []
        self._tendons: list[str] = []
        self._fixed_tendons: list[str] = []
        self.controls: dict[str, float] = {}
        self.drawn = {"angle": self._random.choice(("degree", "radian")), "meshdir": "shapes"} | {
            name: self._random.choice(_COMPILER[name]) for name in self._random.sample(sorted(_COMPILER), 4)
        }
        self._turns = self.drawn["angle"] == "degree"
        self.files = self._write()

    def save(self, folder: Path) -> Path:
        """Write the files and return the main one."""
        (folder / "shapes").mkdir(exist_ok=True)
        write_stl(folder / "shapes" / "wedge.stl", WEDGE)
        for name, text in self.files.items():
            (folder / name).write_text(text)
        return folder / "robot.xml"

    # -- numbers

    def _numbers(self, count: int, low: float, high: float) -> str:
        return " ".join(f"{self._random.uniform(low, high):.3f}" for _ in range(count))

    def _angles(self, *radians: float) -> str:
        return " ".join(f"{degrees(each) if self._turns else each:.4f}" for each in radians)

    def _maybe(self, chance: float, text: Callable[[], str]) -> str:
        return f" {text()}" if self._random.random() < chance else ""

    def _pose(self, size: float = 0.2) -> str:
        """Return attributes of a place, the orientation in one of MJCF's ways."""
        r = self._random
        a, b, c = (r.uniform(-1.5, 1.5) for _ in range(3))
        turn = r.choice((
            "", f'quat="{self._numbers(4, 0.2, 1)}"', f'euler="{self._angles(a, b, c)}"',
            f'axisangle="{self._numbers(3, 0.1, 1)} {self._angles(a)}"',
            f'xyaxes="1 {self._numbers(2, -0.4, 0.4)} 0 1 {self._numbers(1, -0.4, 0.4)}"',
            f'zaxis="{self._numbers(2, -0.5, 0.5)} 1"',
        ))  # fmt: skip
        return f'pos="{self._numbers(3, -size, size)}" {turn}'

    def _class(self) -> str:
        return self._maybe(0.4, lambda: f'class="{self._random.choice(("outer", "inner", "innermost"))}"')

    # -- sections

    def _write(self) -> dict[str, str]:
        r = self._random
        tops = [self._top(0)]
        self._inner = len(self._sites)
        tops += [self._top(1), self._top(2)]
        places = "".join(self._site() for _ in range(2))
        tendons = "".join(self._tendon(number) for number in range(3))
        compiler = " ".join(f'{name}="{value}"' for name, value in self.drawn.items())
        settings = (
            f'<mujoco><compiler {compiler}/><default><joint damping="{self._numbers(1, 0.05, 0.2)}"/>'
            f'<general gear="{self._numbers(1, 0.5, 2)}"/><default class="outer">'
            f'<joint stiffness="{self._numbers(1, 0.1, 2)}" axis="{self._numbers(3, 0.1, 1)}"/>'
            f'<site pos="{self._numbers(3, -0.1, 0.1)}" size="0.02"/>'
            f'<equality solref="0.03 {self._numbers(1, 0.7, 1.2)}"/>'
            '<include file="inner.xml"/></default></default></mujoco>'
        )
        inner = (
            f'<mujocoinclude><default class="inner"><joint armature="{self._numbers(1, 0.001, 0.02)}"/>'
            f'<geom density="{self._numbers(1, 300, 2000)}" group="{r.randrange(4)}"/>'
            f'<motor gear="{self._numbers(1, 0.2, 0.5)}"/><tendon stiffness="{self._numbers(1, 0.1, 5)}"/>'
            f'<default class="innermost"><joint stiffness="{self._numbers(1, 0.1, 2)}" '
            f'frictionloss="{self._numbers(1, 0.001, 0.01)}"/><tendon damping="{self._numbers(1, 0.1, 1)}"/>'
            f'<equality solimp="0.8 {self._numbers(1, 0.85, 0.95)} 0.01"/>'
            "</default></default></mujocoinclude>"
        )
        equality = "".join(self._equality() for _ in range(r.randrange(1, 4))) if self._joined else ""
        actuators = "".join(self._actuator(number) for number in range(r.randrange(1, 5)))
        sensors = "".join(self._sensor(number) for number in range(6))
        hills = ground = ""
        if self._touching:
            size, elevation = 'size="1.2 1 0.2 0.1" nrow="6" ncol="5"', self._numbers(30, 0, 1)
            hills = f'<hfield name="hills" {size} elevation="{elevation}"/>'
            place = f'pos="0 0 {self._numbers(1, -0.7, -0.4)}"'
            ground = f'<geom name="hills" type="hfield" hfield="hills" {place}/>'
        folder = "gone/" if self.drawn.get("strippath") == "true" else ""
        robot = (
            '<mujoco model="robot"><include file="settings.xml"/>'
            '<option cone="elliptic" magnetic="0.1 0.2 0.3"/>'
            f'<asset><mesh name="wedge" file="{folder}wedge.stl" '
            f'inertia="{r.choice(("convex", "exact", "shell"))}"/>{hills}</asset>'
            f'<worldbody>{ground}{places}{tops[0]}<include file="second.xml"/>{tops[2]}</worldbody>'
            f"<tendon>{tendons}</tendon><equality>{equality}</equality>"
            f"<actuator>{actuators}</actuator><sensor>{sensors}</sensor></mujoco>"
        )
        second = f"<mujocoinclude>{tops[1]}</mujocoinclude>"
        return {"robot.xml": robot, "settings.xml": settings, "inner.xml": inner, "second.xml": second}

    def _top(self, number: int) -> str:
        kind = self._random.choice(("free", "joint", "joint", "none")) if number else "joint"
        joint = {"free": "<freejoint/>", "none": ""}.get(kind)
        return self._body(self._joint() if joint is None else joint, depth=0)

    def _body(self, joint: str, depth: int) -> str:
        r, name = self._random, f"body{len(self._bodies)}"
        self._bodies.append(name)
        inner = joint + "".join(self._geom() for _ in range(r.randrange(1, 3)))
        inner += "".join(self._site() for _ in range(r.randrange(1, 3)))
        inner += self._maybe(
            1 if self.drawn.get("inertiafromgeom") == "false" else 0.3,
            lambda: (
                f'<inertial mass="{self._numbers(1, 0.2, 1)}" {self._pose(0.05)} '
                f'diaginertia="{self._numbers(3, 0.02, 0.03)}"/>'
            ),
        )
        for _ in range(r.randrange(1, 3) if depth == 0 else r.randrange(3 - depth)):
            loose = self._joined or r.random() < 0.7
            below = self._maybe(0.2, self._joint) + self._joint(may_be_ball=True) if loose else ""
            inner += self._body(below, depth + 1)
        attributes = self._maybe(0.3, lambda: f'childclass="{r.choice(("outer", "innermost"))}"')
        attributes += self._maybe(
            0.15, lambda: f'gravcomp="{1 if r.random() < 0.7 or not self._joined else 0.4}"'
        )
        if "freejoint" in joint:
            attributes = attributes.partition("childclass")[0]
        return f'<body name="{name}" {self._pose(0.3)}{attributes}>{inner}</body>'

    def _joint(self, *, may_be_ball: bool = False) -> str:
        r, name = self._random, f"joint{len(self._joints)}"
        if may_be_ball and r.random() < 0.1:
            self._balls += 1
            return f'<joint name="ball{self._balls}" type="ball" damping="0.05"{self._class()}/>'
        self._joints.append(name)
        turns = r.random() < 0.75
        size = self._angles if turns else lambda *each: " ".join(f"{one / 5:.4f}" for one in each)
        texts = f'axis="{self._numbers(3, -1, 1)}" pos="{self._numbers(3, -0.05, 0.05)}"'
        texts += self._maybe(0.3, lambda: f'ref="{size(r.uniform(-0.5, 0.5))}"')
        texts += self._maybe(0.3, lambda: f'springref="{size(r.uniform(-0.5, 0.5))}" stiffness="1"')
        texts += self._maybe(
            0.4, lambda: f'range="{size(-r.uniform(0.5, 1))} {size(r.uniform(0.5, 1))}" limited="true"'
        )
        kind = "hinge" if turns else "slide"
        return f'<joint name="{name}" type="{kind}" {texts}{self._class()}/>'

    def _geom(self) -> str:
        name = f"geom{len(self._geoms)}"
        self._geoms.append(name)
        shape = self._random.choice((
            'type="sphere" size="0.05"', 'type="box" size="0.05 0.03 0.1"', 'type="mesh" mesh="wedge"',
            'type="capsule" size="0.03" fromto="0 0 0 0.1 0.1 0"', 'type="ellipsoid" size="0.05 0.03 0.04"',
            'type="cylinder" size="0.04 0.03"',
        ))  # fmt: skip
        place = "" if "fromto" in shape else self._pose(0.1)
        group = self._maybe(0.4, lambda: f'group="{self._random.randrange(5)}"')
        mass = self._maybe(0.5, lambda: f'mass="{self._numbers(1, 0.1, 0.5)}"')
        touches = self._touching and self._random.random() < 0.5
        bits = f'friction="{self._numbers(1, 0.1, 1)}"' if touches else 'contype="0" conaffinity="0"'
        return f'<geom name="{name}" {shape} {place}{group}{self._class()}{mass} {bits}/>'

    def _site(self) -> str:
        name = f"site{len(self._sites)}"
        self._sites.append(name)
        place = self._maybe(0.8, self._pose)
        return f'<site name="{name}"{place}{self._class()}/>'

    def _two(self, names: Sequence[str]) -> tuple[str, str]:
        one, other = self._random.sample(names, 2)
        return one, other

    def _tendon(self, number: int) -> str:
        r, name = self._random, f"tendon{number}"
        limits = self._maybe(0.3, lambda: 'range="0.05 0.8" limited="true"')
        springs = self._maybe(0.4, lambda: f'stiffness="{self._numbers(1, 1, 10)}" springlength="0.2"')
        if number == 0 and len(self._joints) > 1:
            self._fixed_tendons.append(name)
            wraps = "".join(f'<joint joint="{each}" coef="{self._numbers(1, -1, 1)}"/>'
                            for each in self._two(self._joints))  # fmt: skip
            return f'<fixed name="{name}"{springs}{self._class()}>{wraps}</fixed>'
        self._tendons.append(name)
        sites = [
            r.choice(self._sites[: self._inner]),
            *r.sample(self._sites[self._inner :], r.choice((1, 2))),
        ]
        r.shuffle(sites)
        wraps = "".join(f'<site site="{each}"/>' for each in sites)
        return f'<spatial name="{name}"{limits}{springs}{self._class()}>{wraps}</spatial>'

    def _equality(self) -> str:
        r = self._random
        usual = self._class() + self._maybe(0.2, lambda: 'active="false"')
        usual += self._maybe(0.3, lambda: 'solref="0.04 1"')
        one, other = self._two(self._bodies)
        bodies = f'body1="{one}"' + self._maybe(0.7, lambda: f'body2="{other}"')
        ends = self._two(self._sites)
        sites = f'site1="{ends[0]}" site2="{ends[1]}"'
        curve = f'polycoef="{self._numbers(5, -0.3, 0.3)}"'
        place = f"{self._numbers(3, -0.2, 0.2)} {self._numbers(4, 0.2, 1)}"
        posed = self._maybe(0.5, lambda: f'anchor="{self._numbers(3, -0.1, 0.1)}"')
        posed += self._maybe(0.5, lambda: f'relpose="{place}"')
        scale = f'torquescale="{self._numbers(1, 0.5, 2)}"'
        kinds = [
            f'<connect {bodies} anchor="{self._numbers(3, -0.1, 0.1)}"{usual}/>',
            f"<connect {sites}{usual}/>",
            f"<weld {bodies}{posed} {scale}{usual}/>",
            f"<weld {sites} {scale}{usual}/>",
            f'<tendon tendon1="tendon1" tendon2="tendon2" {curve}{usual}/>',
            f'<tendon tendon1="tendon2" {curve}{usual}/>',
        ]
        if len(self._joints) > 1:
            leader, follower = self._two(self._joints)
            kinds += [
                f'<joint joint1="{leader}" joint2="{follower}" {curve}{usual}/>',
                f'<joint joint1="{leader}" {curve}{usual}/>',
            ]
        return r.choice(kinds)

    def _actuator(self, number: int) -> str:
        r, name = self._random, f"act{number}"
        one, other = self._two(self._sites)
        joint = r.choice(self._joints)
        gear = f'gear="{self._numbers(6, -1, 1)}"'
        ends = r.choice((
            f'site="{one}" {gear}', f'site="{one}" refsite="{other}" {gear}', f'joint="{joint}"',
            f'jointinparent="{joint}"', f'tendon="{r.choice((*self._tendons, *self._fixed_tendons))}"',
            f'cranksite="{one}" slidersite="{other}" cranklength="0.6"',
        ))  # fmt: skip
        limits = self._maybe(0.3, lambda: 'forcerange="-0.5 0.5" forcelimited="true"')
        kinds = {
            "motor": "", "position": 'kp="1"' + self._maybe(0.3, lambda: 'kv="0.3"'), "velocity": 'kv="0.2"',
            "intvelocity": 'kp="2" actrange="-0.4 0.4"', "damper": 'kv="0.5" ctrlrange="0 1"',
            "cylinder": 'timeconst="0.1" diameter="0.1" bias="0.1 -0.2 -0.1"',
            "general": 'biastype="affine" gainprm="2" biasprm="0.1 -1 -0.1" dyntype="filter" dynprm="0.05"',
            "muscle": 'lengthrange="0.05 0.7" force="3"',
        }  # fmt: skip
        kind = r.choice(sorted(kinds))
        if kind == "muscle":
            ends, limits = f'tendon="{r.choice(self._tendons)}"', ""
        self.controls[name] = round(r.uniform(0, 1), 2)
        return f'<{kind} name="{name}" {ends} {kinds[kind]}{limits}/>'

    def _sensor(self, number: int) -> str:
        r, name = self._random, f"sensor{number}"
        site, other = self._two(self._sites)
        objects = [
            f'objtype="{kind}" objname="{r.choice(names)}"'
            for kind, names in (
                ("site", self._sites),
                ("geom", self._geoms),
                ("body", self._bodies),
                ("xbody", self._bodies),
            )
        ]
        relative = self._maybe(0.4, lambda: f'reftype="site" refname="{other}"')
        kinds = [
            *(f'<{kind} name="{name}" site="{site}"/>' for kind in (
                "accelerometer", "velocimeter", "gyro", "force", "torque", "magnetometer")),
            *(f'<{kind} name="{name}" {r.choice(objects)}{relative}/>' for kind in (
                "framepos", "framequat", "framexaxis", "framelinvel", "frameangvel")),
            *(f'<{kind} name="{name}" {r.choice(objects)}/>' for kind in ("framelinacc", "frameangacc")),
            *(f'<{kind} name="{name}" tendon="{r.choice(self._tendons)}"/>' for kind in (
                "tendonpos", "tendonvel", "tendonactuatorfrc")),
            *(f'<{kind} name="{name}" body="{r.choice(self._bodies)}"/>' for kind in (
                "subtreecom", "subtreelinvel", "subtreeangmom")),
            *(f'<{kind} name="{name}" joint="{r.choice(self._joints)}"/>' for kind in (
                "jointpos", "jointvel", "jointactuatorfrc")),
            *(f'<{kind} name="{name}" actuator="{r.choice(sorted(self.controls))}"/>' for kind in (
                "actuatorpos", "actuatorvel", "actuatorfrc")),
        ]  # fmt: skip
        return r.choice(kinds)
