"""Robots in URDF, converted to SDF.

Gazebo does the same: attributes of a ``<robot>`` become elements, and the contents of its ``<gazebo>`` blocks
for a link, a joint or the whole (sensors, plugins, friction, materials) move to their places in SDF. Every
element keeps its line, so that messages point into the URDF file. See http://wiki.ros.org/urdf/XML.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.scene.bodies import TINTS
from nrp_core.scene.consistency import MODEL, WORLD, rigid_groups
from nrp_core.scene.reading.context import Element, Notes
from nrp_core.scene.reading.geometry import DEFAULT_SIZES
from nrp_core.scene.reading.plugins import ROS_CONTROL, check_parameters, plugin_name
from nrp_core.scene.reading.repairs import MASSLESS
from nrp_core.scene.urdf.elements import (
    for_engine,
    from_attributes,
    new,
    numbers,
    pose,
    read_commas_as_spaces,
)
from nrp_core.scene.urdf.transmissions import (
    START,
    give_parameters,
    read_ros2_control,
    read_transmission,
    trajectory_plugins,
)
from nrp_core.scene.urdf.vocabulary import check_vocabulary

_BEFORE_SDF = ("sensor", "controller", "body", "geom", "interface")
"""Namespaces of elements of the first Gazebo; SDF has elements of some of these names without one."""
_OF_CONTROL = (
    *(("ros", name) for name in ("namespace", "remapping")),
    *((name,) for name in ("robotNamespace", "robotParam", "robotSimType", "legacyModeNS", "controlPeriod")),
)
"""Parameters of plugins that run controllers."""
_NAMES = {"selfCollide": "self_collide"}
"""The names that elements have in SDF, if not the same."""
_VALUES = {
    *("kp", "kd", "minDepth", "maxVel", "maxContacts", "laserRetro", "stopCfm", "stopErp", "material"),
    *("mu1", "mu2", "selfCollide", "turnGravityOff", "dampingFactor"),
}
"""Elements that hold a value only."""
_SPRINGS = {"springStiffness": "spring_stiffness", "springReference": "spring_reference"}


def apply_block(block: Element, model: Element, notes: Notes) -> None:
    """Move the contents of a ``<gazebo>`` block to their places in SDF."""
    name = block.attributes.get("reference")
    target = model
    if name == WORLD:
        return  # it keeps the world as a link in Gazebo's own conversion
    if name is not None:
        named = {part.attributes["name"]: part for part in model.all("link", "joint")}
        if name not in named:
            hint = did_you_mean(name, named)
            notes.warn(
                block, Code.NRP383, f"ignored: the robot has no link or joint '{name}'{hint}", subject=name
            )
            return
        target = named[name]
    for child in block.children:
        if child.tag.rpartition(":")[0] in _BEFORE_SDF:
            message = f"<{child.tag}> is of Gazebo before its version 1.0 and SDF: ignored"
            notes.warn(child, Code.NRP383, message, subject=child.tag, alike="before SDF")
            continue
        if child.tag in _VALUES:
            for inner in child.children:
                message = f"<{inner.tag}> in <{child.tag}>, which holds a value, is ignored"
                notes.warn(inner, Code.NRP383, message, subject=inner.tag)
        if not _controls_nothing(child, notes):
            _give(child, target)


def _controls_nothing(element: Element, notes: Notes) -> bool:
    """Return whether an element is a plugin that runs controllers and names no file with them."""
    if element.tag != "plugin" or plugin_name(element) not in ROS_CONTROL or element.word("parameters"):
        return False
    for tags in _OF_CONTROL:
        element.find(*tags)
    check_parameters(element, notes)
    return True


def _give(child: Element, target: Element) -> None:
    if child.tag == "material":
        script = new("script", child, new("name", child, text=_value(child)))
        for visual in target.all("visual"):
            visual.children.insert(0, new("material", child, script))
    elif child.tag in ("mu1", "mu2"):
        for collision in target.all("collision"):
            friction = _within(collision, child, "surface", "friction", "ode")
            friction.children.append(new(child.tag.replace("mu1", "mu"), child, text=_value(child)))
    elif child.tag in _SPRINGS:
        dynamics = _within(target, child, "axis", "dynamics")
        dynamics.children.append(new(_SPRINGS[child.tag], child, text=_value(child)))
    elif child.tag == "turnGravityOff":
        target.children.append(new("gravity", child, text="0" if _value(child) in ("1", "true") else "1"))
    elif child.tag == "dampingFactor":
        slower = (new(tag, child, text=_value(child)) for tag in ("linear", "angular"))
        target.children.append(new("velocity_decay", child, *slower))
    elif child.tag in ("visual", "collision"):
        for part in target.all(child.tag):
            part.children[:0] = child.children
    else:
        name = _NAMES.get(child.tag)
        target.children.append(new(name, child, text=_value(child)) if name else child)


def _within(element: Element, at: Element, *tags: str) -> Element:
    """Return the descendant along a path of tags, created if it is missing."""
    here = element
    for tag in tags:
        found = here.find(tag)
        if found is None:
            found = new(tag, at)
            here.children.append(found)
        here = found
    return here


def _value(element: Element) -> str:
    return element.text or element.attributes.get("value", "")


_READ = ("link", "joint", "material", "gazebo")
_ELSEWHERE = ("sensor",)  # for hardware drivers
_SHAPES = ("box", "sphere", "cylinder", "capsule")
_SHARES = 4
"""The numbers of a colour: red, green, blue and opacity."""
_KINDS = {"spherical": "ball"}
"""The types of joints that have another name in SDF; ``spherical`` is PyBullet's."""
_ENDED = ("revolute", "prismatic")
"""The types of joints that must have limits."""
_OF_ENGINES = ("mujoco",)
"""Elements of a robot that hold elements for one engine, such as ``<mujoco><option .../></mujoco>``."""


@dataclass(frozen=True, slots=True)
class _Robot:
    """The context for converting the parts of a robot.

    Args:
        links: names of its links.
        joints: names of its joints.
        held_by: the joint that holds each link.
        materials: the materials that visuals refer to by name.
        carried: the links without mass that are fixed to one with mass.
        notes: receives warnings.
    """

    links: Collection[str]
    joints: Collection[str]
    held_by: Mapping[str, Element]
    materials: Mapping[str, Element]
    carried: Collection[str]
    notes: Notes

    @classmethod
    def of(cls, robot: Element, notes: Notes) -> _Robot:
        links = {link.attribute("name") for link in robot.all("link")}
        held_by = {joint.require("child").attribute("link"): joint for joint in robot.all("joint")}
        materials = {material.attribute("name"): material for material in robot.all("material")}
        joints = {joint.attribute("name") for joint in robot.all("joint")}
        return cls(links, joints, held_by, materials, set(_massless_links(robot)), notes)

    def joint_name(self, joint: Element) -> str:
        """Return the name of a joint in SDF, where it must differ from those of links."""
        return self.renamed(joint.attribute("name"))

    def renamed(self, joint: str) -> str:
        """Return the name in SDF of a joint with a name in URDF."""
        return f"{joint}_joint" if joint in self.links else joint


def to_sdf(element: Element, notes: Notes) -> Element:
    """Return the ``<sdf>`` equivalent to a ``<robot>``.

    Raises:
        SceneError: a required element or attribute is missing.
    """
    read_commas_as_spaces(element, notes)
    check_vocabulary(element, notes)
    _drop_doubled_joints(element, notes)
    robot = _Robot.of(element, notes)
    _warn_of_loose(element, robot)
    model = new("model", element, name=element.attribute("name"))
    model.attributes[MASSLESS] = "true"
    joints = give_parameters(element)
    model.children += _static(element, notes)
    for child in element.children:
        if child.tag == "link" and child.attribute("name") != WORLD:
            model.children.append(_link(child, robot))
        elif child.tag == "joint" and child.attribute("type") != "floating":
            model.children.append(_joint(child, robot))
        elif child.tag == "transmission":
            model.children += read_transmission(child, joints, notes)
        elif child.tag == "ros2_control":
            model.children += read_ros2_control(child, notes)
        elif child.tag not in (*_READ, *_OF_ENGINES) and ":" not in child.tag:
            known = child.tag in _ELSEWHERE
            reason = "is not supported" if known else f"is unknown: ignored{did_you_mean(child.tag, _READ)}"
            notes.warn(child, Code.NRP383, f"the <{child.tag}> of a <robot> {reason}", subject=child.tag)
    model.children += _for_engines(element)
    for block in element.all("gazebo"):
        apply_block(block, model, notes)
    if not any(plugin.word("parameters") for plugin in model.all("plugin")):
        model.children += trajectory_plugins(model)
    for plugin in model.all("plugin"):
        _name_joints(plugin, robot)
    return new("sdf", element, model, version="1.11")


def _drop_doubled_joints(robot: Element, notes: Notes) -> None:
    """Drop one of two joints with the same name, if one is in a ``<gazebo>`` block.

    Where Gazebo converts URDF, it drops links without mass with their joints. So the joint of the block stays
    if that of the robot only holds such a link.
    """
    blocks = {
        joint.attribute("name"): (block, joint)
        for block in robot.all("gazebo")
        for joint in block.all("joint")
    }
    joints = robot.all("joint")
    links = {link.attribute("name"): link for link in robot.all("link")}
    for joint in joints:
        if joint.attribute("name") not in blocks:
            continue
        block, other = blocks[joint.attribute("name")]
        child = joint.require("child").attribute("link")
        carries = any(each.require("parent").attribute("link") == child for each in joints)
        light = child in links and not _has_mass(links[child]) and not carries
        if light:
            robot.children.remove(joint)
            robot.children.remove(links[child])
        else:
            block.children.remove(other)
        used = "Gazebo's joint is used, without the massless link" if light else "the robot's joint is used"
        message = f"the joint '{joint.attribute('name')}' is in the robot and in a <gazebo> block: {used}"
        notes.warn(other, Code.NRP266, message, subject=joint.attribute("name"))


def _for_engines(robot: Element) -> Iterator[Element]:
    """Yield the elements that are meant for one engine, in the namespace of that engine."""
    for child in robot.children:
        if ":" in child.tag:
            yield child
        elif child.tag in _OF_ENGINES:
            yield from (for_engine(each, child.tag) for each in child.children)
    for link in robot.all("link"):  # PyBullet's own reader takes <contact> from links
        name = link.attribute("name")
        yield from (for_engine(each, "pybullet", link=name) for each in link.all("contact"))


def _warn_of_loose(element: Element, robot: _Robot) -> None:
    """Warn of root links other than the first, which ROS does not allow; joints of Gazebo hold, too."""
    of_gazebo = (joint.find("child") for block in element.all("gazebo") for joint in block.all("joint"))
    held = {WORLD, *robot.held_by, *(child.text for child in of_gazebo if child is not None)}
    first, *loose = [link for link in element.all("link") if link.attribute("name") not in held] or [element]
    for link in loose:
        other = first.attribute("name")
        robot.notes.warn(
            link,
            Code.NRP264,
            f"no joint holds '{link.attribute('name')}': it moves freely, like '{other}'",
            subject=link.attribute("name"),
        )


def _name_joints(element: Element, robot: _Robot) -> None:
    """Replace the names of joints in a plugin by those in SDF."""
    if "joint" in element.tag.lower():
        element.text = robot.renamed(element.text)
    if "joint_name" in element.attributes:
        element.attributes["joint_name"] = robot.renamed(element.attributes["joint_name"])
    for child in element.children:
        _name_joints(child, robot)


# -- links


def _massless_links(robot: Element) -> Iterator[str]:
    """Yield the links without mass that are fixed to one with mass, which in URDF is the whole mass."""
    heavy = {link.attribute("name") for link in robot.all("link") if _has_mass(link)}
    fixed = [
        tuple(joint.require(end).attribute("link") for end in ("parent", "child"))
        for joint in robot.all("joint")
        if joint.attribute("type") == "fixed"
    ]
    names = [link.attribute("name") for link in robot.all("link")]
    groups = rigid_groups(names, [ends for ends in fixed if WORLD not in ends])
    return (name for name in names if name not in heavy and groups[name] & heavy)


def _has_mass(link: Element) -> bool:
    mass = link.section("inertial").find("mass")
    return mass is not None and mass.parse_numbers(mass.attribute("value"), 1) != (0.0,)


def _static(robot: Element, notes: Notes) -> Iterator[Element]:
    """Yield ``<static>`` for a robot whose masses are all 0 and that has no joint that moves, as PyBullet."""
    stated = [link for link in robot.all("link") if link.section("inertial").find("mass") is not None]
    moving = any(joint.attribute("type") != "fixed" for joint in robot.all("joint"))
    if stated and not moving and not any(map(_has_mass, stated)):
        notes.warn(robot, Code.NRP264, f"no link of '{robot.attribute('name')}' has a mass: it never moves")
        yield new("static", robot, text="true")


def _link(link: Element, robot: _Robot) -> Element:
    name = link.attribute("name")
    result = new("link", link, *_place(robot.held_by.get(name), robot), name=name)
    inertial = link.find("inertial")
    if name in robot.carried:
        result.attributes[MASSLESS] = "true"
    elif inertial is not None:
        result.children.append(_inertial(inertial, robot.notes))
    for tag in ("visual", "collision"):
        for number, shaped in enumerate(link.all(tag)):
            named = shaped.attributes.get("name") or f"{name}_{tag}" + (f"_{number}" if number else "")
            part = new(tag, shaped, pose(shaped), *map(_geometry, shaped.all("geometry")[:1]), name=named)
            part.children += _material(shaped, robot) if tag == "visual" else []
            result.children.append(part)
    return result


def _place(joint: Element | None, robot: _Robot) -> Iterator[Element]:
    """Yield the pose of a link: at its joint, or for a floating joint relative to its parent."""
    if joint is not None and joint.attribute("type") == "floating":
        yield pose(joint, relative_to=_parent_frame(joint))
    elif joint is not None:
        yield new("pose", joint, relative_to=robot.joint_name(joint))


def _inertial(inertial: Element, notes: Notes) -> Element:
    mass = new("mass", inertial, text=inertial.require("mass").attribute("value"))
    given = inertial.find("inertia")
    if given is None:  # of 0, so that it is computed; SDF's default would be 1 kg m^2
        nothing = (new(f"i{axis}", inertial, text="0") for axis in ("xx", "yy", "zz"))
        return new("inertial", inertial, mass, new("inertia", inertial, *nothing), pose(inertial))
    missing = [name for name in ("ixx", "iyy", "izz") if name not in given.attributes]
    if missing:
        message = f"the <inertia> has no {', '.join(missing)}: 1 kg m^2 is used, as in SDF"
        notes.warn(given, Code.NRP384, message)
    inertia = new("inertia", given, *from_attributes(given, "ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
    return new("inertial", inertial, mass, inertia, pose(inertial))


def _geometry(geometry: Element) -> Element:
    if not geometry.children:  # ROS refuses it, and SDF allows it
        raise geometry.error("<geometry> needs a shape: box, cylinder, sphere or mesh")
    shape = geometry.children[0]
    if shape.tag == "mesh":
        parts = [new("uri", shape, text=shape.attribute("filename")), *from_attributes(shape, "scale")]
    else:
        for size in DEFAULT_SIZES[shape.tag] if shape.tag in _SHAPES else ():
            shape.attribute(size)  # an error if it is missing: URDF has no default sizes
        parts = list(from_attributes(shape, "size", "radius", "length", "normal"))
    return new("geometry", geometry, new(shape.tag, shape, *parts))


def _material(visual: Element, robot: _Robot) -> list[Element]:
    material = visual.find("material")
    if material is None:
        return []
    name = material.attributes.get("name", "")
    defined = material if material.children else robot.materials.get(name)
    color, image = (defined.find(tag) if defined else None for tag in ("color", "texture"))
    look = [] if color is None else [new("diffuse", color, text=_rgba(color, robot.notes))]
    if image is not None and image.attributes.get("filename"):  # exported files often have an empty one
        look.append(_matt(image))
    if not look:
        robot.notes.warn(
            material, Code.NRP258, f"the material '{name}' has no colour: shown grey", subject=name
        )
        return []
    return [new("material", material, *look, **{TINTS: "true"})]


def _rgba(color: Element, notes: Notes) -> str:
    """Return the four numbers of a colour; of more, the first four."""
    text = color.attribute("rgba")
    shares = text.split()
    if len(shares) > _SHARES:
        used = " ".join(shares[:_SHARES])
        message = f'a colour has {_SHARES} numbers, and rgba="{text}" has {len(shares)}: {used} is used'
        notes.warn(color, Code.NRP258, message, subject="rgba")
        return used
    return text


def _matt(image: Element) -> Element:
    """Return the ``<pbr>`` of a matt surface with an image."""
    numbers = (new(tag, image, text=text) for tag, text in (("roughness", "1"), ("metalness", "0")))
    albedo = new("albedo_map", image, text=image.attribute("filename"))
    return new("pbr", image, new("metal", image, albedo, *numbers))


# -- joints


def _joint(joint: Element, robot: _Robot) -> Element:
    ends = [joint.require(end) for end in ("parent", "child")]
    for end in ends:
        if (link := end.attribute("link")) not in {*robot.links, WORLD}:
            hint = did_you_mean(link, robot.links)
            raise end.error(f"the {end.tag} of a joint is '{link}', but the robot has no such link{hint}")
    return new(
        "joint",
        joint,
        *(new(end.tag, end, text=end.attribute("link")) for end in ends),
        pose(joint, relative_to=_parent_frame(joint)),
        _axis(joint, robot),
        name=robot.joint_name(joint),
        type=_KINDS.get(joint.attribute("type"), joint.attribute("type")),
    )


def _parent_frame(joint: Element) -> str:
    parent = joint.require("parent").attribute("link")
    return MODEL if parent == WORLD else parent


def _without_no_limits(values: Sequence[Element], joint: Element, robot: _Robot) -> list[Element]:
    """Return values without the limits of effort or velocity that would prevent the joint from moving."""
    zero = [value for value in values if value.tag in ("effort", "velocity")
            if value.parse_numbers(value.text, 1, finite=False)[0] <= 0]  # fmt: skip
    if zero and joint.attribute("type") != "fixed":
        name, (limit,) = joint.attribute("name"), zero[0].parse_numbers(zero[0].text, 1, finite=False)
        what, verb = " and ".join(value.tag for value in zero), "is" if len(zero) == 1 else "are"
        message = f"the {what} of the joint '{name}' {verb} limited to {limit:g}, so that it could not move"
        robot.notes.warn(zero[0], Code.NRP384, f"{message}: no limit", subject=name, alike="no limit")
    return [value for value in values if value not in zero]


def _is_crossed(limit: Element, joint: Element, robot: _Robot) -> bool:
    """Return whether limits are crossed, by which PyBullet and ODE mean none."""
    ends = {end.tag: end.numbers(1, finite=False)[0] for end in from_attributes(limit, "lower", "upper")}
    lower, upper = ends.get("lower", 0.0), ends.get("upper", 0.0)
    if lower > upper and joint.attribute("type") != "fixed":
        message = (
            f"the lower limit ({lower:g}) of the joint '{joint.attribute('name')}' is above the upper one "
            f"({upper:g}): no limits, as in PyBullet"
        )
        robot.notes.warn(limit, Code.NRP384, message, subject=joint.attribute("name"))
    return lower > upper


def _is_endless(limit: Element, joint: Element, robot: _Robot) -> bool:
    """Return whether a joint has limits of effort and velocity only, so that it has no ends in PyBullet.

    Makers of robots with wheels mean that; in ROS it could not move.
    """
    _warn_without_limits(limit, joint, robot)
    if joint.attribute("type") not in _ENDED or limit.attributes.keys() & {"lower", "upper"}:
        return False
    name = joint.attribute("name")
    message = (
        f"the <limit> of the joint '{name}' has no lower and no upper: it moves without ends, as in "
        "PyBullet, and not at all in ROS"
    )
    robot.notes.warn(limit, Code.NRP384, message, subject=name, alike="no ends")
    return True


def _warn_without_limits(limit: Element, joint: Element, robot: _Robot) -> None:
    """Warn of limits that URDF requires and the file lacks."""
    missing = [tag for tag in ("effort", "velocity") if tag not in limit.attributes]
    if missing and joint.attribute("type") != "fixed":
        name = joint.attribute("name")
        message = f"the <limit> of the joint '{name}' has no {' and no '.join(missing)}: not limited"
        robot.notes.warn(limit, Code.NRP384, message, subject=name, alike="no limit")


def _axis(joint: Element, robot: _Robot) -> Element:
    axis = joint.find("axis") or joint
    parts = [new("xyz", axis, text=numbers(axis, "xyz", "1 0 0"))]
    for mimic in joint.all("mimic"):
        leader = mimic.attribute("joint")
        if leader not in robot.joints:
            hint = did_you_mean(leader, robot.joints)
            name = joint.attribute("name")
            message = f"the joint '{name}' moves freely: there is no '{leader}' for it to mimic{hint}"
            robot.notes.warn(mimic, Code.NRP383, message, subject=name, alike="no leader")
            continue
        leader = robot.renamed(leader)
        parts.append(new("mimic", mimic, *from_attributes(mimic, "multiplier", "offset"), joint=leader))
    parts += joint.all(START)
    for child in joint.all("limit", "dynamics"):
        given = from_attributes(child, "lower", "upper", "effort", "velocity", "damping", "friction")
        values = _without_no_limits(list(given), joint, robot)
        if child.tag == "limit" and _is_crossed(child, joint, robot):
            values = [value for value in values if value.tag not in ("lower", "upper")]
        elif child.tag == "limit" and not _is_endless(child, joint, robot):  # in URDF a missing limit is 0
            values += [new(tag, child, text="0") for tag in ("lower", "upper") if tag not in child.attributes]
        parts.append(new(child.tag, child, *values))
    return new("axis", axis, *parts)
