"""The parts of MJCF that a scene cannot express, as elements for MuJoCo (:mod:`.native`, :mod:`.mechanisms`).

Values come from the compiled model, so that defaults and classes of the file are resolved. Only those that
differ from MuJoCo's own defaults are written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np

from nrp_world_mujoco.actuators import LAW, SINGLE, Actuator, actuators_of
from nrp_world_mujoco.library import mujoco
from nrp_world_mujoco.mechanisms import FREE, WORLD
from nrp_world_mujoco.mjcf_sensors import SensorElements
from nrp_world_mujoco.muscles import muscle_elements
from nrp_world_mujoco.native import OF_SCENE_GEOM, OF_SCENE_JOINT, pose_in_file
from nrp_world_mujoco.one_file import FILE, SETTINGS
from nrp_world_mujoco.schema import attributes_of, stated, text_of

_SOLREF, _SOLIMP = [0.02, 1.0], [0.9, 0.95, 0.001, 0.5, 2.0]
_RUBS = ("condim", "friction", "priority")
"""A scene has another rule for contacts of different friction, so that those of a file are always stated."""
_BITS = ("contype", "conaffinity")
_JOINT: dict[str, tuple[str, Any]] = {
    "solreflimit": ("jnt_solref", _SOLREF),
    "solimplimit": ("jnt_solimp", _SOLIMP),
    "margin": ("jnt_margin", 0.0),
}
_STOP, _RUBBING = ("solreflimit", "solimplimit"), ("solreffriction", "solimpfriction")
"""Scenes have harder stops and dry friction than MuJoCo, so that those of a file are always stated."""
_OF_DOF: dict[str, tuple[str, Any]] = {
    "armature": ("dof_armature", 0.0),
    "solreffriction": ("dof_solref", _SOLREF),
    "solimpfriction": ("dof_solimp", _SOLIMP),
}
_OF_FREE_DOF = ("armature", "damping", "frictionloss")
_OF_OPTION = ("actuatorgroupdisable", "cone", "gravity", "integrator", "timestep")
"""Options that are read in another way, or that the experiment sets; all others pass through."""
_FLAGS = ("contact", "spring", "damper", "limit", "gravity", "equality", "filterparent", "clampctrl",
          "refsafe", "warmstart", "nativeccd", "multiccd")  # fmt: skip
"""Flags that a file may switch off without disabling the servos of this program."""
_ENABLED = ("diagexact", "override", "speculative")
"""Flags that a file may switch on."""
_TENDON: dict[str, tuple[str, Any]] = {
    **{name: (name, 0.0) for name in ("frictionloss", "armature", "margin")},
    "solreflimit": ("solref_lim", _SOLREF),
    "solimplimit": ("solimp_lim", _SOLIMP),
    "solreffriction": ("solref_fri", _SOLREF),
    "solimpfriction": ("solimp_fri", _SOLIMP),
}
_OF_TENDON = (*_TENDON, "group", "limited", "material", "range", "rgba", "springlength", "user", "width")
_OF_JOINT = (*OF_SCENE_JOINT, *_JOINT, *_OF_DOF, "springdamper")
_OF_ACTUATOR = (*LAW, "actearly", "actlimited", "actrange", "cranklength", "group", "input", "user")
"""Attributes that the compiled model has in another way, or that do not act; all others pass through."""
_INPUTS = {1: "pos", 2: "vel"}
"""What a control of one number means, by its bits."""
_INERT = {"mjDSBL_SENSOR", "mjDSBL_MIDPHASE", "mjDSBL_ISLAND", "mjDSBL_EULERDAMP", "mjDSBL_AUTORESET",
          "mjNDISABLE", "mjNENABLE", "mjENBL_ENERGY", "mjENBL_FWDINV", "mjENBL_SLEEP"}  # fmt: skip
"""Flags that do not change a motion, or that the experiment sets."""
_SHAPES = {mujoco.mjtGeom.mjGEOM_SPHERE: "sphere", mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder"}
_SITES = {**_SHAPES, mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule", mujoco.mjtGeom.mjGEOM_BOX: "box",
          mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid"}  # fmt: skip


class Names(NamedTuple):
    """The names of the parts of a file in the scene, by their numbers."""

    body: Callable[[int], str]
    joint: Callable[[int], str]
    geom: Callable[[int], str]
    model: Callable[[int], str]
    """The model that a body is in."""


class NativeElements:
    """The elements of each model of a file.

    Args:
        spec: the specification that MuJoCo read.
        model: the compiled model.
        names: the names of its parts in the scene.
        cone: the friction cones that the file requests; empty: those of scenes.
        meshes: attributes of the meshes that are in files, by name.
    """

    def __init__(
        self, spec: Any, model: Any, names: Names, cone: str, meshes: Mapping[str, dict[str, str]]
    ) -> None:
        self._m, self.names, self._cone, self._meshes = model, names, cone, meshes
        fresh, self._option = mujoco.MjSpec(), spec.option
        self._given = {
            "joint": (spec.joints, fresh.worldbody.add_joint(), _OF_JOINT),
            "tendon": (spec.tendons, fresh.add_tendon(), _OF_TENDON),
            "geom": (spec.geoms, fresh.worldbody.add_geom(), (*OF_SCENE_GEOM, *_RUBS, *_BITS)),
            "general": (spec.actuators, fresh.add_actuator(), _OF_ACTUATOR),
        }
        self._lines: dict[str, list[str]] = {}
        self._sites = dict[tuple[str, int], None]()
        self._ground = names.model(0)
        self.tops = {names.model(body): body for body in range(model.nbody) if not model.body_parentid[body]}
        """The first body of each model."""
        self.controlled = {each.number: each for each in actuators_of(spec, model)}
        self.actuators: dict[str, list[tuple[str, float, float]]] = {}
        """The actuators of each model that do not control a joint: name, and range of the control."""
        self.muscles: dict[str, dict[str, str]] = {}
        """The elements in the plugin of each muscle, by model and name."""
        self.sensors = SensorElements(model, self)
        for part in (self._options, self._bodies, self._joints, self._geoms, self._tendons, self._equalities,
                     self._contacts, self._acting, self.sensors.lines):  # fmt: skip
            for owner, line in part():
                self._lines.setdefault(owner, []).append(line)
        for owner, site in self._sites:
            self._lines.setdefault(owner, []).append(self._site(owner, site))

    def of(self, model: str) -> Iterable[str]:
        """Return the elements of a model."""
        return self._lines.get(model, ())

    @property
    def touching(self) -> set[int]:
        """The geoms that touch something: by their masks or in contact pairs."""
        m = self._m
        masked = np.flatnonzero((m.geom_contype != 0) | (m.geom_conaffinity != 0)).tolist()
        touching = {*masked, *m.pair_geom1.tolist(), *m.pair_geom2.tolist()}
        return {geom for geom in touching if self._has_shape(geom)}

    def _has_shape(self, geom: int) -> bool:
        """Return whether a scene has the shape of a geom."""
        kind = mujoco.mjtGeom(self._m.geom_type[geom])
        if kind == mujoco.mjtGeom.mjGEOM_HFIELD:
            return is_ground(self._m, geom)
        return bool(kind != mujoco.mjtGeom.mjGEOM_SDF)

    def _others(self, element: str, number: int) -> dict[str, str]:
        """Return the attributes of a part that no other method here reads from the compiled model."""
        parts, usual, without = self._given[element]
        part = next(each for each in parts if each.id == number)
        return stated(part, usual, element, without)

    # -- options and properties

    def _options(self) -> Iterator[tuple[str, str]]:
        given = self._m.opt
        differing = stated(self._option, mujoco.MjSpec().option, "option", _OF_OPTION)
        if self._cone:
            differing["cone"] = self._cone
        flags = {name: "disable" for name in _FLAGS if given.disableflags & _bit("DSBL", name)}
        flags |= {name: "enable" for name in _ENABLED if given.enableflags & _bit("ENBL", name)}
        if differing or flags:
            inner = _element("flag", flags) if flags else ""
            moving = [body for body in range(1, self._m.nbody) if self._m.body_parentid[body] == 0]
            owner = self.names.model(moving[0]) if moving else self._ground
            yield owner, _element("option", differing, inner)
        settings = {name: text_of(getattr(given, name), name) for name in SETTINGS}
        undamped = given.disableflags & mujoco.mjtDisableBit.mjDSBL_EULERDAMP
        inner = _element("flag", {"eulerdamp": "disable"}) if undamped else ""
        for owner in self.tops.keys() - {self._ground}:
            yield owner, _element(FILE, settings, inner)

    def _bodies(self) -> Iterator[tuple[str, str]]:
        lifts = self._m.body_gravcomp
        for body in np.flatnonzero((lifts != 0) & (lifts != 1) & (self._m.body_weldid != 0)).tolist():
            lift = {"link": self.names.body(body), "gravcomp": _text(lifts[body])}
            yield self.names.model(body), _element("body", lift)

    def _joints(self) -> Iterator[tuple[str, str]]:
        m = self._m
        for joint in range(m.njnt):
            dof, values = m.jnt_dofadr[joint], self._others("joint", joint)
            if mujoco.mjtJoint(m.jnt_type[joint]) == mujoco.mjtJoint.mjJNT_FREE:
                yield from self._free(joint)
                continue
            ball = mujoco.mjtJoint(m.jnt_type[joint]) == mujoco.mjtJoint.mjJNT_BALL
            values |= self._springs(joint, bool(m.jnt_stiffness[joint]) and ball)
            if ball and m.jnt_limited[joint]:
                values |= {"limited": "true", "range": _text(m.jnt_range[joint])}
            for numbers, at in ((_JOINT, joint), (_OF_DOF, dof)):
                for name, (field, usual) in numbers.items():
                    stated = (name in _STOP and m.jnt_limited[joint]) or (
                        name in _RUBBING and m.dof_frictionloss[dof] > 0
                    )
                    if stated or np.any(getattr(m, field)[at] != usual):
                        values[name] = _text(getattr(m, field)[at])
            if values:
                yield (
                    self.names.model(m.jnt_bodyid[joint]),
                    _element("joint", {"name": self.names.joint(joint), **values}),
                )

    def _springs(self, joint: int, always: bool) -> dict[str, str]:
        """Return the polynomial spring and damper of a joint; with ``always``, any spring."""
        m, dof = self._m, int(self._m.jnt_dofadr[joint])
        laws = {"stiffness": (m.jnt_stiffness[joint], m.jnt_stiffnesspoly[joint]),
                "damping": (m.dof_damping[dof], m.dof_dampingpoly[dof])}  # fmt: skip
        return {name: _text([first, *rest] if np.any(rest) else first) for name, (first, rest) in laws.items()
                if np.any(rest) or (always and name == "stiffness")}  # fmt: skip

    def _free(self, joint: int) -> Iterator[tuple[str, str]]:
        m, body, dof = self._m, int(self._m.jnt_bodyid[joint]), int(self._m.jnt_dofadr[joint])
        numbers = {name: float(getattr(m, f"dof_{name}")[dof]) for name in _OF_FREE_DOF}
        values = {name: _text(number) for name, number in numbers.items() if number}
        values |= self._springs(joint, bool(m.jnt_stiffness[joint]))
        if values:
            yield self.names.model(body), _element("freejoint", {"link": self.names.body(body), **values})

    def _geoms(self) -> Iterator[tuple[str, str]]:
        m = self._m
        for geom in sorted(self.touching):
            values = self._others("geom", geom)
            values |= {name: _text(getattr(m, f"geom_{name}")[geom]) for name in _RUBS}
            if not (m.geom_contype[geom] or m.geom_conaffinity[geom]):
                values |= dict.fromkeys(_BITS, "0")
            if mujoco.mjtGeom(m.geom_type[geom]) == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
                values |= {"type": "ellipsoid", "size": _text(m.geom_size[geom])}
            if mujoco.mjtGeom(m.geom_type[geom]) == mujoco.mjtGeom.mjGEOM_HFIELD:
                values["base"] = _text(m.hfield_size[m.geom_dataid[geom]][3])
            body = int(m.geom_bodyid[geom])
            mesh = self._mesh(geom)
            if mesh in self._meshes:
                values |= {"mesh": mesh, **{k: _text(v) for k, v in pose_in_file(m, geom).items()}}
                added = self.names.model(body), _element("mesh", {"name": mesh, **self._meshes[mesh]})
                if added[1] not in self._lines.get(added[0], ()):
                    yield added
            place = {"link": self.names.body(body), "name": self.names.geom(geom)}
            yield self.names.model(body), _element("geom", place | values)

    def _mesh(self, geom: int) -> str:
        """Return the name of the mesh of a shape, empty for other shapes."""
        kind = mujoco.mjtGeom(self._m.geom_type[geom])
        of_mesh = kind == mujoco.mjtGeom.mjGEOM_MESH
        return self._m.mesh(int(self._m.geom_dataid[geom])).name if of_mesh else ""

    # -- mechanisms

    def _tendons(self) -> Iterator[tuple[str, str]]:
        m = self._m
        for tendon in range(m.ntendon):
            path = range(m.tendon_adr[tendon], m.tendon_adr[tendon] + m.tendon_num[tendon])
            kinds = [mujoco.mjtWrap(m.wrap_type[step]) for step in path]
            fixed = kinds[0] == mujoco.mjtWrap.mjWRAP_JOINT
            owner = self.names.model(self.body_of_tendon(tendon))
            values = {
                name: _text(getattr(m, f"tendon_{field}")[tendon])
                for name, (field, usual) in _TENDON.items()
                if np.any(getattr(m, f"tendon_{field}")[tendon] != usual)
            }
            values |= self._others("tendon", tendon)
            shift = self._shift_of_tendon(tendon)
            if m.tendon_limited[tendon]:
                values |= {"limited": "true", "range": _text(m.tendon_range[tendon] - shift)}
            values["springlength"] = _text(m.tendon_lengthspring[tendon] - shift)
            yield from self._wraps(owner, path, kinds)
            steps = "".join(self._step(owner, step, kind) for step, kind in zip(path, kinds, strict=True))
            name = {"name": self.name("tendon", tendon)}
            yield owner, _element("tendon", {}, _inner("fixed" if fixed else "spatial", name | values, steps))

    def body_of_tendon(self, tendon: int) -> int:
        """Return the first body on the path of a tendon that moves; the first one if none does."""
        m, kinds = self._m, mujoco.mjtWrap
        bodies = {kinds.mjWRAP_JOINT: m.jnt_bodyid, kinds.mjWRAP_SITE: m.site_bodyid}
        path = range(m.tendon_adr[tendon], m.tendon_adr[tendon] + m.tendon_num[tendon])
        steps = [(kinds(m.wrap_type[step]), int(m.wrap_objid[step])) for step in path]
        return self._moving(int(bodies[kind][part]) for kind, part in steps if kind in bodies)

    def _moving(self, bodies: Iterable[int]) -> int:
        """Return the first of some bodies that moves; the first one if none does."""
        return max(bodies, key=lambda body: bool(self._m.body_weldid[body]))

    def _wraps(self, owner: str, path: Iterable[int], kinds: Iterable[Any]) -> Iterator[tuple[str, str]]:
        m = self._m
        for step, kind in zip(path, kinds, strict=True):
            if kind in (mujoco.mjtWrap.mjWRAP_SPHERE, mujoco.mjtWrap.mjWRAP_CYLINDER):
                geom = int(m.wrap_objid[step])
                body = int(m.geom_bodyid[geom])
                values = {"name": f"wrap_{geom}", "size": _text(m.geom_size[geom]),
                          "type": _SHAPES[mujoco.mjtGeom(m.geom_type[geom])],
                          **self.place(owner, body, m.geom_pos[geom], m.geom_quat[geom])}  # fmt: skip
                line = self.holder(owner, body), _element("wrap", values)
                if line[1] not in self._lines.get(line[0], ()):
                    yield line

    def _step(self, owner: str, step: int, kind: Any) -> str:
        m, part, number = self._m, int(self._m.wrap_objid[step]), float(self._m.wrap_prm[step])
        match kind:
            case mujoco.mjtWrap.mjWRAP_JOINT:
                joint = self._full(owner, int(m.jnt_bodyid[part]), self.names.joint(part))
                return _inner("joint", {"joint": joint, "coef": _text(number)})
            case mujoco.mjtWrap.mjWRAP_PULLEY:
                return _inner("pulley", {"divisor": _text(number)})
            case mujoco.mjtWrap.mjWRAP_SITE:
                return _inner("site", {"site": self.used_site(owner, part)})
        side = {"sidesite": self.used_site(owner, int(number))} if number >= 0 else {}
        geom = self.placed(owner, int(m.geom_bodyid[part]), f"wrap_{part}")
        return _inner("geom", {"geom": geom, **side})

    def _shift_of_tendon(self, tendon: int) -> float:
        """Return the length of a fixed tendon where all joints of the scene are at 0."""
        m = self._m
        steps = range(m.tendon_adr[tendon], m.tendon_adr[tendon] + m.tendon_num[tendon])
        return sum(
            float(m.wrap_prm[step]) * self._zero(int(m.wrap_objid[step]))
            for step in steps
            if mujoco.mjtWrap(m.wrap_type[step]) == mujoco.mjtWrap.mjWRAP_JOINT
        )

    def _equalities(self) -> Iterator[tuple[str, str]]:
        m, kinds = self._m, mujoco.mjtEq
        for number in range(m.neq):
            kind, data = mujoco.mjtEq(m.eq_type[number]), m.eq_data[number]
            one, other = int(m.eq_obj1id[number]), int(m.eq_obj2id[number])
            values = {"solref": _text(m.eq_solref[number]), "solimp": _text(m.eq_solimp[number])}
            values["active"] = "true" if m.eq_active0[number] else "false"
            if kind in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
                tag = "connect" if kind == kinds.mjEQ_CONNECT else "weld"
                yield from self._joined(tag, number, values)
            elif kind in (kinds.mjEQ_JOINT, kinds.mjEQ_TENDON):
                joints = kind == kinds.mjEQ_JOINT
                tag = "joint" if joints else "tendon"
                owner = self.names.model(self._end_body(joints, one))
                ends = {f"{tag}1": self._end(joints, owner, one)}
                if other >= 0:
                    ends[f"{tag}2"] = self._end(joints, owner, other)
                yield (
                    owner,
                    _element("equality", {}, _inner(tag, {**ends, "polycoef": _text(data[:5]), **values})),
                )

    def _end_body(self, joints: bool, part: int) -> int:
        if joints:
            return int(self._m.jnt_bodyid[part])
        return self.body_of_tendon(part)

    def _end(self, joints: bool, owner: str, part: int) -> str:
        name = self.names.joint(part) if joints else self.name("tendon", part)
        return self._full(owner, self._end_body(joints, part), name)

    def _joined(self, tag: str, number: int, values: dict[str, str]) -> Iterator[tuple[str, str]]:
        """Yield a constraint between two places, which become sites."""
        m, data = self._m, self._m.eq_data[number]
        ends = [int(m.eq_obj1id[number]), int(m.eq_obj2id[number])]
        if tag == "weld":
            values["torquescale"] = _text(data[10])
        if mujoco.mjtObj(m.eq_objtype[number]) == mujoco.mjtObj.mjOBJ_SITE:
            owner = self.names.model(self._moving(m.site_bodyid[ends].tolist()))
            sites = [self.used_site(owner, end) for end in ends]
        else:
            owner = self.names.model(self._moving(ends))
            weld = tag == "weld"
            poses = [(data[3:6], data[6:10]) if weld else (data[:3], _NO_TURN),
                     (data[:3], _NO_TURN) if weld else (data[3:6], _NO_TURN)]  # fmt: skip
            sites = []
            for end, body, (position, turn) in zip((1, 2), ends, poses, strict=True):
                name = f"equality_{number}_{end}"
                place = self.place(owner, body, position, turn)
                yield self.holder(owner, body), _element("site", {"name": name, **place})
                sites.append(self.placed(owner, body, name))
        named = {"site1": sites[0], "site2": sites[1]}
        yield owner, _element("equality", {}, _inner(tag, named | values))

    def _contacts(self) -> Iterator[tuple[str, str]]:
        m = self._m
        for pair in range(m.npair):
            geoms = [int(m.pair_geom1[pair]), int(m.pair_geom2[pair])]
            if not self.touching.issuperset(geoms):
                continue
            bodies = [int(m.geom_bodyid[geom]) for geom in geoms]
            owner = self.names.model(max(bodies, key=bool))
            names = [f"{self.names.body(body)}/{self.names.geom(geom)}"
                     for body, geom in zip(bodies, geoms, strict=True)]  # fmt: skip
            ends = {f"geom{n}": self._full(owner, body, name)
                    for n, body, name in zip((1, 2), bodies, names, strict=True)}  # fmt: skip
            fields = {name: f"pair_{'dim' if name == 'condim' else name}" for name in attributes_of("pair")}
            values = {name: _text(getattr(m, field)[pair])
                      for name, field in fields.items() if hasattr(m, field)}  # fmt: skip
            if not m.pair_solreffriction[pair].any():
                del values["solreffriction"]
            yield owner, _element("contact", {}, _inner("pair", ends | values))
        for signature in m.exclude_signature.tolist():
            bodies = [signature >> 16, signature & 0xFFFF]
            owner = self.names.model(max(bodies, key=bool))
            ends = {f"body{n}": self._full(owner, body, self.names.body(body))
                    for n, body in zip((1, 2), bodies, strict=True)}  # fmt: skip
            yield owner, _element("contact", {}, _inner("exclude", ends))
        for owner in dict.fromkeys(self.names.model(body) for body in self._meeting()):
            yield owner, _element("contact", {"self": "true"})

    def _meeting(self) -> Iterator[int]:
        """Yield bodies that may touch another one of their model: by their masks, and not excluded."""
        m = self._m
        geoms = np.flatnonzero((m.geom_contype != 0) | (m.geom_conaffinity != 0))
        bodies, types, affinities = m.geom_bodyid[geoms], m.geom_contype[geoms], m.geom_conaffinity[geoms]
        rigid, roots = m.body_weldid[bodies], m.body_rootid[bodies]
        above = m.body_weldid[m.body_parentid[rigid]]
        meet = (types[:, None] & affinities | affinities[:, None] & types) != 0
        meet &= (roots[:, None] == roots) & (rigid[:, None] != rigid) & (roots != 0)
        if not m.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT:
            # shapes fixed to the world have contacts, too (filterBodyPair in engine_collision_driver.c)
            moves = (rigid[:, None] != 0) & (rigid != 0)
            meet &= ~(moves & ((rigid[:, None] == above) | (above[:, None] == rigid)))
        apart = {frozenset((each >> 16, each & 0xFFFF)) for each in m.exclude_signature.tolist()}
        pairs = np.unique(np.stack([bodies[side] for side in np.nonzero(meet)], axis=1), axis=0)
        yield from (one for one, other in pairs.tolist() if frozenset((one, other)) not in apart)

    def _acting(self) -> Iterator[tuple[str, str]]:
        m = self._m
        for number in range(len(m.actuator_trntype)):
            if number in self.controlled:
                yield from self._declared(self.controlled[number])
                continue
            if m.actuator_ctrlnum[number] != 1:
                continue
            owner, target, shift = self.target(number)
            name = self.name("actuator", number)
            values = {"name": name, **target, **self._law(number, shift), **self._others("general", number)}
            control = int(m.actuator_ctrladr[number])
            for limit, field in (("ctrl", "ctrlrange"), ("force", "forcerange"), ("act", "actrange")):
                at = control if limit == "ctrl" else number
                if getattr(m, f"actuator_{limit}limited")[at]:
                    values |= {
                        f"{limit}limited": "true",
                        field: _text(getattr(m, f"actuator_{field}")[at]),
                    }
            limited = bool(m.actuator_ctrllimited[control])
            low, high = m.actuator_ctrlrange[control].tolist() if limited else (-np.inf, np.inf)
            muscle = self._muscle(number, owner, name)
            if muscle:
                self.muscles.setdefault(owner, {})[name] = muscle
            else:
                self.actuators.setdefault(owner, []).append((name, low, high))
            yield owner, _element("actuator", {}, _inner("general", values))

    def _muscle(self, number: int, owner: str, name: str) -> str:
        """Return the elements in the plugin of a muscle; empty if an actuator is another one."""
        points = []
        if mujoco.mjtTrn(self._m.actuator_trntype[number]) == mujoco.mjtTrn.mjTRN_TENDON:
            tendon = int(self._m.actuator_trnid[number][0])
            path = range(self._m.tendon_adr[tendon], self._m.tendon_adr[tendon] + self._m.tendon_num[tendon])
            sites = [int(self._m.wrap_objid[step]) for step in path
                     if mujoco.mjtWrap(self._m.wrap_type[step]) == mujoco.mjtWrap.mjWRAP_SITE]  # fmt: skip
            bodies = [int(self._m.site_bodyid[site]) for site in sites]
            if all(not body or self.names.model(body) == owner for body in bodies):
                points = [self.place(owner, body, self._m.site_pos[site], self._m.site_quat[site])
                          for site, body in zip(sites, bodies, strict=True)]  # fmt: skip
        return muscle_elements(self._m, number, points)

    def _declared(self, servo: Actuator) -> Iterator[tuple[str, str]]:
        """Yield the settings that let a servo act as in the file."""
        gains = {
            "position": {"kp": _text(servo.p), "kv": _text(servo.d)},
            "velocity": {"kv": _text(servo.p)},
            "effort": {},
        }[servo.kind]
        if gains:
            owner = self.names.model(int(self._m.jnt_bodyid[servo.joint]))
            joint = {"joint": self.names.joint(servo.joint)}
            yield owner, _element("actuator", {}, _inner(servo.kind, joint | gains))

    def target(self, number: int) -> tuple[str, dict[str, str], float]:
        """Return the model of an actuator, its transmission, and its length with all joints at 0."""
        m, kinds = self._m, mujoco.mjtTrn
        kind, (one, other) = mujoco.mjtTrn(m.actuator_trntype[number]), m.actuator_trnid[number].tolist()
        gear = m.actuator_gear[m.actuator_outadr[number]]
        values = {"gear": _text(gear)}
        if kind in (kinds.mjTRN_JOINT, kinds.mjTRN_JOINTINPARENT):
            body = int(m.jnt_bodyid[one])
            owner, tag = self.names.model(body), "joint" if kind == kinds.mjTRN_JOINT else "jointinparent"
            free = mujoco.mjtJoint(m.jnt_type[one]) == mujoco.mjtJoint.mjJNT_FREE
            name = f"{self.names.body(body)}/{FREE}" if free else self.names.joint(one)
            return owner, {tag: name, **values}, float(gear[0]) * self._zero(one)
        if kind == kinds.mjTRN_TENDON:
            owner = self.names.model(self._end_body(False, one))
            shift = float(gear[0]) * self._shift_of_tendon(one)
            return owner, {"tendon": self.name("tendon", one), **values}, shift
        if kind == kinds.mjTRN_BODY:
            return self.names.model(one), {"body": self.names.body(one), **values}, 0.0
        ends = [int(m.site_bodyid[end]) for end in (one, other) if end >= 0]
        owner = self.names.model(self._moving(ends))
        if kind == kinds.mjTRN_SITE:
            ref = {"refsite": self.used_site(owner, other)} if other >= 0 else {}
            return owner, {"site": self.used_site(owner, one), **ref, **values}, 0.0
        crank = {"cranksite": self.used_site(owner, one), "slidersite": self.used_site(owner, other)}
        return owner, {**crank, "cranklength": _text(m.actuator_cranklength[number]), **values}, 0.0

    def _law(self, number: int, shift: float) -> dict[str, str]:
        """Return how an actuator turns its control into a force; lengths begin where joints are at 0."""
        m = self._m
        bias = m.actuator_biasprm[number].copy()
        types = {
            field: getattr(mujoco, f"mjt{field[:-4].title()}")(getattr(m, f"actuator_{field}")[number])
            for field in ("dyntype", "gaintype", "biastype")
        }
        if types["biastype"] == mujoco.mjtBias.mjBIAS_AFFINE:
            bias[0] += bias[1] * shift
        values = {field: kind.name.rpartition("_")[2].lower() for field, kind in types.items()}
        numbers = {
            "dynprm": m.actuator_dynprm[number],
            "gainprm": m.actuator_gainprm[number],
            "biasprm": bias,
        }
        values |= {field: _text(each) for field, each in numbers.items()}
        lengths = m.actuator_lengthrange[m.actuator_outadr[number]]
        if lengths.any():
            values["lengthrange"] = _text(lengths - shift)
        if (control := int(m.actuator_ctrlspec[number])) in _INPUTS:
            values["input"] = _INPUTS[control]
        if m.actuator_actearly[number]:
            values["actearly"] = "true"
        return values

    # -- names

    def _zero(self, joint: int) -> float:
        """Return MuJoCo's position of a joint that is at 0 in the scene."""
        single = mujoco.mjtJoint(self._m.jnt_type[joint]) in SINGLE
        return float(self._m.qpos0[self._m.jnt_qposadr[joint]]) if single else 0.0

    def name(self, kind: str, number: int) -> str:
        return getattr(self._m, kind)(number).name or f"{kind}_{number}"

    def _full(self, owner: str, body: int, name: str) -> str:
        """Return the name of a part on a body as the elements of a model use it."""
        model = self.names.model(body)
        return name if model == owner else f"{model}/{name}"

    def holder(self, owner: str, body: int) -> str:
        """Return the model that owns a place on a body; on the world body, the model that uses it.

        A file may have nothing else on the world body, and as a robot it has its own place in the scene.
        """
        return self.names.model(body) if body else owner

    def place(self, owner: str, body: int, position: Any, turn: Any) -> dict[str, str]:
        """Return the link and the pose of a place on a body, relative to the model on the world body."""
        link, top = self.names.body(body), self.tops[owner]
        if not body and owner != self._ground:
            link = WORLD
            origin, back = np.empty(3), np.empty(4)
            mujoco.mju_negPose(origin, back, self._m.body_pos[top], self._m.body_quat[top])
            there, turned = np.empty(3), np.empty(4)
            mujoco.mju_mulPose(there, turned, origin, back, np.array(position), np.array(turn))
            position, turn = there, turned
        return {"link": link, "pos": _text(position), "quat": _text(turn)}

    def placed(self, owner: str, body: int, name: str) -> str:
        """Return the name of a place on a body as the elements of a model use it."""
        return self._full(owner, body, name) if body else name

    def used_site(self, owner: str, site: int) -> str:
        body = int(self._m.site_bodyid[site])
        self._sites[self.holder(owner, body), site] = None
        return self.placed(owner, body, self.name("site", site))

    def _site(self, owner: str, site: int) -> str:
        m = self._m
        place = self.place(owner, int(m.site_bodyid[site]), m.site_pos[site], m.site_quat[site])
        shape = {"size": _text(m.site_size[site]), "type": _SITES[mujoco.mjtGeom(m.site_type[site])]}
        shaped = shape if site in self.sensors.touched_sites else {}
        return _element("site", {"name": self.name("site", site), **place, **shaped})


def is_ground(model: Any, geom: int) -> bool:
    """Return whether a geom is on the world body, or on a body that nothing in its tree moves."""
    root = model.body_rootid[model.geom_bodyid[geom]]
    return not root or not model.body_jntnum[model.body_rootid == root].any()


def not_passed(model: Any) -> Iterator[str]:
    """Yield the acting parts of a file that the elements do not contain."""
    for number in np.flatnonzero(model.actuator_ctrlnum != 1).tolist():
        name = model.actuator(number).name or f"actuator_{number}"
        yield f"the actuator '{name}', which has {model.actuator_ctrlnum[number]} controls"
    passed = {f"mjDSBL_{name.upper()}" for name in _FLAGS} | _INERT
    passed |= {f"mjENBL_{name.upper()}" for name in _ENABLED}
    for flags, bits in (
        (model.opt.disableflags, mujoco.mjtDisableBit),
        (model.opt.enableflags, mujoco.mjtEnableBit),
    ):
        for name, bit in bits.__members__.items():
            if name not in passed and flags & bit.value:
                yield f"the flag {name.rpartition('_')[2].lower()} of its <option>"
    if model.opt.disableactuator:
        yield "actuatorgroupdisable of its <option>"
    sleeps = model.opt.enableflags & _bit("ENBL", "sleep")
    if sleeps and model.opt.sleep_tolerance > mujoco.MjOption().sleep_tolerance:
        yield "the flag sleep of its <option>, by which bodies stop that still move"


def _bit(kind: str, flag: str) -> int:
    bits = mujoco.mjtDisableBit if kind == "DSBL" else mujoco.mjtEnableBit
    return int(getattr(bits, f"mj{kind}_{flag.upper()}", 0))


_NO_TURN = [1.0, 0.0, 0.0, 0.0]


def _element(tag: str, values: dict[str, str], inner: str = "") -> str:
    return _inner(f"mujoco:{tag}", values, inner)


def _inner(tag: str, values: dict[str, str], inner: str = "") -> str:
    attributes = "".join(f" {name}={quoteattr(value)}" for name, value in values.items())
    return f"<{tag}{attributes}>{inner}</{tag}>"


def _text(numbers: Any) -> str:
    return " ".join(f"{float(number):.17g}" for number in np.ravel(numbers))
