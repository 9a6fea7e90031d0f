"""Elements and attributes of a file that no reader has looked for: misspelt, misplaced or not simulated.

Readers leave a record in the elements that they read (:class:`nrp_core.xml.Element`), so that whatever they
do not read is reported without a list of what they read. Elements of other namespaces (``gz:...``) are
accepted, as the specification of SDF requires.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Final

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.findings import Code, Level
from nrp_core.scene.bodies import PRESERVED, ROLLING, TINTS
from nrp_core.scene.reading.context import Element, Notes, Reading
from nrp_core.scene.reading.plugins import wrong_file
from nrp_core.scene.reading.repairs import MASSLESS
from nrp_core.scene.rigid import ROUNDED_TURN_RAD

SECTIONS: Final = frozenset(
    {"torsional", "soft_contact", "dart", "contact", "ode", "bullet", "simbody", "physics", "suspension",
     "limit", "projection", "particle_filter", "fluid_added_mass", "auto_inertia_params", "distortion",
     "depth_camera", "save", "lens", "custom_function", "noise", "axis2", "dynamics", "wind", "clip"}
)  # fmt: skip
"""Elements with children, which are reported one by one if no reader looks into the element."""
_NO_DEFAULT, _NEVER = "-", "!"
"""Marks in place of a default: the element is empty by default; no value is the default."""


def _defaults(text: str) -> dict[str, str]:
    """Return the defaults of elements, 0 if they have none in the text."""
    words = (word.partition("=") for word in text.split())
    return {tag: default or "0" for tag, _, default in words}


REMARKS: Final = _defaults(
    # how Gazebo's engines solve contacts and joints
    "kp=1e12 kd=1 max_vel=0.01 min_depth soft_cfm soft_erp=0.2 split_impulse=1 "
    "split_impulse_penetration_threshold=-0.01 poissons_ratio=0.3 elastic_modulus=-1 threshold=100000|1e6 "
    "collide_without_contact_bitmask=1 fdir1=0,0,0 friction2=1 rolling_friction=1 ode/slip "
    "cfm_damping implicit_spring_damper fudge_factor cfm erp=0.2 bounce max_force ode/velocity "
    "provide_feedback must_be_loop_joint limit/stiffness=1e8 limit/dissipation=1 must_be_base_link "
    "gearbox_ratio=1 use_parent_model_frame minDepth maxVel=0.01 fudgeFactor stopCfm stopErp=0.2 "
    "cfmDamping implicitSpringDamper provideFeedback "
    # what Gazebo shows, saves and measures of itself
    "visualize always_on enable_metrics laser_retro laserRetro visibility_flags=4294967295 "
    "anti_aliasing=4 save/path=- frame_id=- range/resolution render_order lighting=1 "
    "double_sided shader=- battery=! namespace=-"
)
"""Elements of SDF that are for Gazebo's solvers and windows, with their defaults: one note."""
NOT_SIMULATED: Final = _defaults(
    "self_collide enable_wind kinematic falloff=1 slip1 slip2 wind/linear_velocity=0,0,0 coefficient=1 "
    "surface_radius bone_attachment=100 dart/stiffness=100 dart/damping=10 "
    "flesh_mass_fraction=0.05 intrinsics/s triggered trigger_topic=- visibility_mask=4294967295 box_type=2d "
    "output=depths clip/near=0.1 clip/far=10 center=0.5,0.5 grav_dir_x=1,0,0 initial_position "
    "metal/environment_map=- ambient_occlusion_map=- normal_map=- emissive_map=- light_map=- "
    "environment_map=- light=! road=! actor=! population=! gripper=! audio_source=! particle_emitter=! "
    "projector=! "
    "xx xy xz xp xq xr yy yz yp yq yr zz zp zq zr pp pq pr qq qr rr"
)
"""Other elements of SDF that have an effect in Gazebo and are not simulated, with their defaults."""
_SILENT: Final = frozenset(
    {"world/audio", "world/gui", "world/scene", "visual/meta", "light/specular", "heightmap/texture",
     "heightmap/blend", "heightmap/use_terrain_paging", "heightmap/sampling", "link/audio_sink", "sdf/state",
     "visual/cast_shadows", "collision/max_contacts", "link/maxContacts", "model/maxContacts",
     "model/allow_auto_disable", "model/disableFixedJointLumping", "joint/disableFixedJointLumping",
     "joint/preserveFixedJoint"}
)  # fmt: skip
"""Elements for Gazebo's programs and images that nearly all rooms have and that do not affect robots."""
_FREE: Final = ("plugin", "state")
"""Elements with contents of their own, which are checked where they are read."""
_ATTRIBUTES: Final = frozenset(
    {"name", "version", "physics/type", "physics/default", "atmosphere/type", "shader/type",
     "collision/concave", "normal_map/type", "light_map/uv_set", "gui/fullscreen",
     "mesh/optimization", "model/placement_frame",
     "save/enabled", "custom_rpy/parent_frame", "grav_dir_x/parent_frame"}
)  # fmt: skip
_OWN: Final = (MASSLESS, PRESERVED, ROLLING, TINTS)
"""Attributes that elements have that were converted from another format."""
_TRUTH: Final = {"true": "1", "false": "0", "": "0"}


@dataclass(frozen=True, slots=True)
class Unread:
    """An element that was not read, or something in it.

    Args:
        element: the element.
        holder: the tag of the element around it.
        message: what is wrong with it; empty for one without an effect on a simulation.
    """

    element: Element
    holder: str
    message: str = ""


def report_unread(reading: Reading) -> None:
    """Warn of what was not read in files, once for each kind; remarks are one note for all files."""
    remarks: list[Element] = []
    notes = reading.notes
    for root in reading.written:
        _check_repeated(root, notes)
    for root in reading.opened:
        for one in find_unread(root):
            if one.message:
                kind = f"{one.holder}/{one.element.tag}"
                alike = f"unread {kind}" if one.element.tag in NOT_SIMULATED else ""
                notes.warn(one.element, Code.NRP383, one.message, subject=one.element.tag, alike=alike)
            else:
                remarks.append(one.element)
        _check_angles(root, notes)
    if remarks:
        values = dict.fromkeys(f"<{each.tag}> {each.text}".rstrip() for each in remarks)
        tags = dict.fromkeys(f"<{each.tag}>" for each in remarks)
        names = list(values if len(values) <= len(tags) else tags)
        said = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        message = f"these elements of Gazebo have no effect here: {said}"
        notes.warn(remarks[0], Code.NRP383, message, subject=remarks[0].tag, level=Level.NOTE)


def _check_repeated(element: Element, notes: Notes) -> None:
    """Warn of elements that contradict an earlier one in the same element, of which only one was read."""
    first: dict[str, Element] = {}
    for child in element.children:
        if child.tag not in _FREE:
            _check_repeated(child, notes)
        is_setting = element.tag == "gazebo" and not child.children and not child.attributes
        if element.asked.get(child.tag, not is_setting):
            continue
        earlier = first.setdefault(child.tag, child)
        if earlier is not child and _contents(earlier) != _contents(child):
            name = element.attributes.get("name")
            owner = f"<{element.tag}>" + (f" '{name}'" if name else "")
            message = (
                f"a second <{child.tag}> in the {owner} is ignored: the one of line {earlier.line} is used"
            )
            kind = f"second {element.tag}/{child.tag}"
            notes.warn(child, Code.NRP383, message, subject=name or element.tag, alike=kind)


def _contents(element: Element) -> object:
    return element.text, element.attributes, [(one.tag, _contents(one)) for one in element.children]


def find_unread(root: Element) -> Iterator[Unread]:
    """Yield what was not read in an element that was."""
    yield from _inside(root, None)


def _inside(element: Element, around: Element | None) -> Iterator[Unread]:
    yield from _attributes(element, around)
    if element.text and _holds_elements(element):
        message = f"the text '{element.text:.40}' in <{element.tag}>, which holds elements, is ignored"
        yield Unread(element, "", message)
    seen: set[str] = set()
    for child in element.children:
        if ":" in child.tag or child.passed_over:
            continue
        if child.tag == "plugin":
            yield from (Unread(child, element.tag, message) for message in _plugin(child, element))
        if child.tag not in element.asked:
            yield from _unread(child, element, around)
        elif child.tag in _FREE:
            yield from _attributes(child, element) if child.tag == "plugin" else ()
        elif child.tag in seen and not element.asked[child.tag]:
            continue  # a second one, of which the first is read, is reported where it contradicts it
        else:
            yield from _inside(child, element)
        seen.add(child.tag)


def _holds_elements(element: Element) -> bool:
    return bool(element.asked) and element.tag not in ("script", "pose")  # old files have a name as text


def _unread(child: Element, element: Element, around: Element | None) -> Iterator[Unread]:
    place = f"{element.tag}/{child.tag}"
    if place in _SILENT:
        return
    known = REMARKS, NOT_SIMULATED
    default = next((each[tag] for each in known for tag in (place, child.tag) if tag in each), None)
    if default is None and child.tag in SECTIONS:
        for inner in child.children:
            if ":" not in inner.tag:
                yield from _unread(inner, child, element)
    elif default is None:
        hint = _place_of(child, element, around)
        message = f"<{child.tag}> is not an element of <{element.tag}>: ignored{hint}"
        yield Unread(child, element.tag, message)
    elif not _is_same(child, default):
        is_remark = place in REMARKS or child.tag in REMARKS
        value = f" {child.text:.40}" if child.text else ""
        shown = [name for name in child.attributes if ":" not in name and name != "name"]
        given = "".join(f' {name}="{child.attributes[name]}"' for name in shown)
        message = f"<{child.tag}{given}>{value} of a <{element.tag}> is not simulated"
        yield Unread(child, element.tag, "" if is_remark else message)


def _is_same(element: Element, default: str) -> bool:
    """Return whether an element has its default, or no value."""
    if default == _NEVER:
        return False
    text = "" if all(":" in name for name in element.attributes) else "?"
    text += element.text.lower()
    if default == _NO_DEFAULT:
        return not text and not element.children
    given = [_TRUTH.get(word, word) for word in text.split()]
    try:
        usual = ([*map(float, each.split(","))] for each in default.split("|"))
        return not given or [*map(float, given)] in usual
    except ValueError:
        return False


def _place_of(child: Element, parent: Element, around: Element | None) -> str:
    """Return the name that was probably meant, or the right parent of an element."""
    near = get_close_matches(child.tag, parent.asked, n=1)
    if near:
        return f"; did you mean <{near[0]}>?"
    if around is not None and child.tag in around.asked:
        return f"; it belongs in <{around.tag}>, beside <{parent.tag}>"
    inner = (*parent.children, *parent.absent.values())
    holders = list(dict.fromkeys(each.tag for each in inner if child.tag in each.asked))
    return f"; it belongs in <{holders[0]}>" if len(holders) == 1 else ""


def _attributes(element: Element, around: Element | None) -> Iterator[Unread]:
    """Yield the attributes that nothing has looked for."""
    asked = element.asked_attributes
    for name in element.attributes.keys() - asked:
        known = name in _ATTRIBUTES or f"{element.tag}/{name}" in _ATTRIBUTES or name in _OWN
        if known or ":" in name or name.startswith("xmlns"):
            continue
        hint = did_you_mean(name, asked | {"name"}) if asked else ""
        message = f"<{element.tag}> has no attribute '{name}': ignored{hint}"
        yield Unread(element, around.tag if around else "", message)


def _plugin(plugin: Element, around: Element) -> Iterator[str]:
    """Yield texts on a plugin's misspelt file, and on elements in it that belong beside it."""
    if problem := wrong_file(plugin):
        yield problem
    for child in plugin.children:
        if child.tag in around.asked and child.tag not in plugin.asked and child.children:
            yield f"<{child.tag}> in a <plugin> is ignored; it belongs beside it"


def _check_angles(element: Element, notes: Notes) -> None:
    """Warn of angles of poses that are probably degrees."""
    for child in element.children:
        if child.tag not in _FREE and ":" not in child.tag:
            _check_angles(child, notes)
    if element.tag != "pose" or element.is_set("degrees"):
        return
    if element.attributes.get("rotation_format", "euler_rpy") != "euler_rpy":
        return
    try:
        widest = max(map(abs, element.numbers(6)[3:]))
    except SceneError:  # empty, or refused where it is read
        return
    if widest > ROUNDED_TURN_RAD:
        message = (
            f"the <pose> {element.text} has an angle of {widest:g} rad, more than a turn; "
            'is it meant in degrees? In SDF <pose degrees="true"> reads it so; xacro has ${radians(...)}'
        )
        notes.warn(element, Code.NRP381, message, subject=element.text)
