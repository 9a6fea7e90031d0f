"""Elements and attributes that are not of SDF, values of the wrong kind, and effects that are not simulated.

All of them cause a warning, so that typing errors are found. Elements of other namespaces (``gz:...``) are
accepted, as the specification requires.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from math import isnan
from typing import Final

from nrp_core.errors import SceneError, did_you_mean, hint_if_close
from nrp_core.findings import Code
from nrp_core.scene.bodies import PRESERVED, TINTS
from nrp_core.scene.reading.context import Element, Notes
from nrp_core.scene.reading.plugins import without_truth_value, wrong_file
from nrp_core.scene.reading.repairs import MASSLESS
from nrp_core.scene.reading.sensors import sensor_types
from nrp_core.scene.rigid import ROUNDED_TURN_RAD

_MAPS: Final = "environment_map:t ambient_occlusion_map:t normal_map emissive_map:t light_map"
_STOPS: Final = "cfm:1 erp:1"
_AROUND: Final = "mean:1 stddev:1 bias_mean:1 bias_stddev:1"

_TABLE: Final = {
    # worlds
    "sdf": "@version world model actor light state",
    "world": "@name audio wind include gravity:3 magnetic_field:3 atmosphere gui physics scene light "
    "frame joint model actor plugin road spherical_coordinates state population",
    "audio": "device:t",
    "wind": "linear_velocity:3",
    "atmosphere": "@type=adiabatic temperature:1 temperature_gradient:1 mass_density:1 pressure:1",
    "spherical_coordinates": "surface_model:t world_frame_orientation:t latitude_deg:1 longitude_deg:1 "
    "elevation:1 heading_deg:1 surface_axis_equatorial:1 surface_axis_polar:1",
    "scene": "ambient:c background:c sky shadows:b fog grid:b origin_visual:b",
    "sky": "time:1 sunrise:1 sunset:1 clouds cubemap_uri:t",
    "clouds": "speed:1 direction:1 humidity:1 mean_size:1 ambient:c",
    "fog": "color:c type:t start:1 end:1 density:1",
    "physics": "@name @default @type=ode|bullet|simbody|dart max_step_size:1 real_time_factor:1 "
    "real_time_update_rate:1 max_contacts:1 gravity:3 magnetic_field:3 dart=dart_engine "
    "simbody=simbody_engine bullet=engine ode=engine",
    "engine": "solver constraints",
    "solver": "type:t min_step_size:1 iters:1 precon_iters:1 sor:1 use_dynamic_moi_rescaling:b "
    "friction_model:t island_threads:1 thread_position_correction:b",
    "constraints": f"{_STOPS} contact_max_correcting_vel:1 contact_surface_layer:1 split_impulse:b "
    "split_impulse_penetration_threshold:1",
    "dart_engine": "solver=dart_solver collision_detector:t",
    "dart_solver": "solver_type:t",
    "simbody_engine": "min_step_size:1 accuracy:1 max_transient_velocity:1 contact=simbody_contact",
    "simbody_contact": "stiffness:1 dissipation:1 plastic_coef_restitution:1 plastic_impact_velocity:1 "
    "static_friction:1 dynamic_friction:1 viscous_friction:1 override_impact_capture_velocity:1 "
    "override_stiction_transition_velocity:1",
    "light": "@name @type=point|directional|spot cast_shadows:b intensity:1 diffuse:c specular:c "
    "attenuation direction:3 spot frame pose visualize:b light_on:b",
    "attenuation": "range:1 constant:1 linear:1 quadratic:1",
    "spot": "inner_angle:1 outer_angle:1 falloff:1",
    "gui": "@fullscreen *",
    "actor": "@name *",
    "population": "@name *",
    "road": "@name *",
    "plugin": "@name @filename *",
    # saved worlds
    "state": "@world_name sim_time:t wall_time:t real_time:t iterations:1 insertions deletions=gone "
    "model=model_state model_state light=light_state light_state joint_state",
    "insertions": "model light",
    "gone": "name:t",
    "model_state": "@name joint=joint_state joint_state model=model_state model_state frame pose "
    "scale:3 link=link_state link_state",
    "joint_state": "@name angle axis_state=way axis2_state=way",
    "way": "position=angle velocity:1 acceleration:1 effort:1",
    "angle": "@axis @degrees :1",
    "link_state": "@name velocity:t acceleration:t wrench:t linear_velocity:3 angular_velocity:3 "
    "linear_acceleration:3 angular_acceleration:3 linear_wrench:3 angular_wrench:3 collision=* frame "
    "pose",
    "light_state": "@name frame pose",
    # models
    "model": "@name @canonical_link @placement_frame static:b self_collide:b allow_auto_disable:b "
    "frame pose link joint plugin gripper include model enable_wind:b",
    "include": "@merge @placement_frame uri:t name:t pose static:b placement_frame:t plugin namespace:t",
    "frame": "@name @attached_to pose",
    "pose": "@relative_to @frame @degrees @rotation_format=euler_rpy|quat_xyzw :p",
    "gripper": "@name *",
    "link": "@name gravity:b enable_wind:b self_collide:b kinematic:b must_be_base_link:b "
    "velocity_decay frame pose inertial collision visual sensor projector audio_sink=* audio_source=* "
    "battery light particle_emitter plugin",
    "velocity_decay": "linear:1 angular:1",
    "battery": "@name voltage:1",
    "projector": "@name *",
    "particle_emitter": "@name @type *",
    "inertial": "@auto mass:1 inertia pose frame density:1 auto_inertia_params=* fluid_added_mass=*",
    "inertia": "ixx:1 ixy:1 ixz:1 iyy:1 iyz:1 izz:1",
    "collision": "@name @concave laser_retro:1 max_contacts:1 frame pose geometry surface density:1 "
    "auto_inertia_params=*",
    "visual": "@name cast_shadows:b laser_retro:1 transparency:1 visibility_flags:t meta frame pose "
    "material geometry plugin",
    "meta": "layer:1",
    "geometry": "empty:t box capsule cone cylinder ellipsoid heightmap image=relief mesh plane "
    "polyline sphere",
    "box": "size:3",
    "sphere": "radius:1",
    "cylinder": "radius:1 length:1",
    "capsule": "radius:1 length:1",
    "cone": "radius:1 length:1",
    "ellipsoid": "radii:3",
    "plane": "normal:3 size:2",
    "mesh": "@optimization uri:t scale:3 submesh convex_decomposition",
    "convex_decomposition": "max_convex_hulls:1 voxel_resolution:1",
    "submesh": "name:t center:b",
    "polyline": "point:2 height:1",
    "relief": "uri:t scale:1 threshold:1 height:1 granularity:1",
    "heightmap": "uri:t size:3 pos:3 texture blend use_terrain_paging:b sampling:1",
    "texture": "size:1 diffuse:t normal:t",
    "blend": "min_height:1 fade_dist:1",
    "material": "script shader render_order:1 lighting:b ambient:c diffuse:c specular:c shininess:1 "
    "emissive:c double_sided:b pbr",
    "script": "name:t uri:t :t",  # the text is the name in old files
    "shader": "@type=vertex|pixel|normal_map_object_space|normal_map_tangent_space normal_map:t",
    "pbr": "metal specular=glossy",
    "metal": f"albedo_map:t roughness:1 roughness_map:t metalness:1 metalness_map:t {_MAPS}",
    "glossy": f"albedo_map:t specular_map:t glossiness:1 glossiness_map:t {_MAPS}",
    "normal_map": "@type=tangent|object :t",
    "light_map": "@uv_set :t",
    "surface": "bounce friction contact=touching soft_contact",
    "bounce": "restitution_coefficient:1 threshold:1",
    "friction": "torsional ode=friction_ode bullet=friction_bullet",
    "torsional": "coefficient:1 use_patch_radius:b patch_radius:1 surface_radius:1 ode=torsional_ode",
    "torsional_ode": "slip:1",
    "friction_ode": "mu:1 mu2:1 fdir1:3 slip1:1 slip2:1",
    "friction_bullet": "friction:1 friction2:1 fdir1:3 rolling_friction:1",
    "touching": "collide_without_contact:b collide_without_contact_bitmask:t collide_bitmask:t "
    "category_bitmask:t poissons_ratio:1 elastic_modulus:1 ode=contact_ode bullet=contact_bullet",
    "contact_ode": "soft_cfm:1 soft_erp:1 kp:1 kd:1 max_vel:1 min_depth:1",
    "contact_bullet": "soft_cfm:1 soft_erp:1 kp:1 kd:1 split_impulse:b split_impulse_penetration_threshold:1",
    "soft_contact": "dart=soft_dart",
    "soft_dart": "bone_attachment:1 stiffness:1 damping:1 flesh_mass_fraction:1",
    # joints
    "joint": "@name @type parent:t child:t gearbox_ratio:1 gearbox_reference_body:t thread_pitch:1 "
    "screw_thread_pitch:1 axis axis2=axis physics=joint_physics frame pose sensor",
    "axis": "initial_position:1 xyz use_parent_model_frame:b dynamics limit mimic",
    "xyz": "@expressed_in :3",
    "mimic": "@joint @axis=axis|axis2 multiplier:1 offset:1 reference:1",
    "dynamics": "damping:1 friction:1 spring_reference:1 spring_stiffness:1",
    "limit": "lower:1 upper:1 effort:1 velocity:1 stiffness:1 dissipation:1",
    "joint_physics": "simbody=joint_simbody ode=joint_ode provide_feedback:b",
    "joint_simbody": "must_be_loop_joint:b",
    "joint_ode": f"cfm_damping:b implicit_spring_damper:b provide_feedback:b fudge_factor:1 {_STOPS} "
    "bounce:1 max_force:1 velocity:1 limit=stop suspension=stop",
    "stop": _STOPS,
    # sensors
    "sensor": "@name @type always_on:b update_rate:1 visualize:b enable_metrics:b topic:t frame_id:t "
    "gz_frame_id:t ignition_frame_id:t frame pose plugin air_flow=* air_pressure air_speed altimeter "
    "camera contact=touched dvl=* force_torque gps=navsat imu lidar logical_camera magnetometer=axes "
    "navsat ray=lidar rfid=* rfidtag=* sonar transceiver",  # and those of registered sensors
    "air_pressure": "reference_altitude:1 pressure=noisy",
    "air_speed": "pressure=noisy",
    "noisy": "noise",
    "noise": f"@type type:t {_AROUND} precision:1 dynamic_bias_stddev:1 "
    "dynamic_bias_correlation_time:1 rate=drift accel=drift",
    "drift": _AROUND,
    "axes": "x=noisy y=noisy z=noisy",
    "altimeter": "vertical_position=noisy vertical_velocity=noisy",
    "camera": "@name triggered:b camera_info_topic:t trigger_topic:t optical_frame_id:t "
    "horizontal_fov:1 image clip save depth_camera segmentation_type:t box_type:t noise distortion "
    "lens visibility_mask:t pose frame",
    "image": "width:1 height:1 format:t anti_aliasing:1",
    "clip": "near:1 far:1",
    "save": "@enabled path:t",
    "depth_camera": "output:t clip",
    "distortion": "k1:1 k2:1 k3:1 p1:1 p2:1 center:2",
    "lens": "type:t scale_to_hfov:b custom_function cutoff_angle:1 env_texture_size:1 intrinsics projection",
    "custom_function": "c1:1 c2:1 c3:1 f:1 fun:t",
    "intrinsics": "fx:1 fy:1 cx:1 cy:1 s:1",
    "projection": "p_fx:1 p_fy:1 p_cx:1 p_cy:1 tx:1 ty:1",
    "touched": "collision:t topic:t",
    "sonar": "min:1 max:1 radius:1 geometry:t",
    "lidar": "scan range=reach noise visibility_mask:t",
    "scan": "horizontal=beams vertical=beams",
    "beams": "samples:1 resolution:1 min_angle:1 max_angle:1 noise",
    "reach": "min:1 max:1 resolution:1",
    "imu": "orientation_reference_frame angular_velocity=axes linear_acceleration=axes "
    "enable_orientation:b noise topic:t",
    "orientation_reference_frame": "localization:t custom_rpy=framed grav_dir_x=framed",
    "framed": "@parent_frame :3",
    "navsat": "position_sensing=level velocity_sensing=level",
    "level": "horizontal=noisy vertical=noisy",
    "logical_camera": "near:1 far:1 aspect_ratio:1 horizontal_fov:1",
    "force_torque": "frame:t measure_direction:t force=axes torque=axes",
    "transceiver": "essid:t frequency:1 min_frequency:1 max_frequency:1 gain:1 power:1 sensitivity:1",
}


@dataclass(frozen=True, slots=True)
class Rule:
    """The possible contents of an element.

    Args:
        attributes: the words that each attribute may be; none for any text.
        children: the rules of its elements.
        value: the kind of its own value; empty if it has none.
        free: whether it may hold anything.
    """

    attributes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    children: Mapping[str, Rule] = field(default_factory=dict)
    value: str = ""
    free: bool = False


def _rules() -> dict[str, Rule]:
    """Return the rules by the names of their entries; rules refer to each other, also in circles."""
    children: dict[str, dict[str, Rule]] = {name: {} for name in _TABLE}
    rules: dict[str, Rule] = {}
    for name, text in _TABLE.items():
        words = text.split()
        attributes = (word[1:].partition("=") for word in words if word[0] == "@")
        rules[name] = Rule(
            {attribute: tuple(filter(None, valid.split("|"))) for attribute, _, valid in attributes},
            children[name],
            "".join(word[1:] for word in words if word[0] == ":"),
            "*" in words,
        )
    for name, text in _TABLE.items():
        for word in text.split():
            if word[0] not in "@:*":
                named, _, kind = word.partition(":")
                tag, _, entry = named.partition("=")
                if entry == "*":
                    children[name][tag] = Rule(free=True)
                else:
                    children[name][tag] = Rule(value=kind) if kind else rules[entry or tag]
    return rules


RULES: Final = _rules()
"""The rules of elements, by the names of entries."""


# elements of the specification that no backend simulates, with the values that have no effect
_NOT_SIMULATED: dict[tuple[str, str], tuple[str, ...]] = {
    ("world", "actor"): (),
    ("world", "population"): (),
    ("world", "road"): (),
    ("wind", "linear_velocity"): ("", "0 0 0"),
    ("model", "gripper"): (),
    ("model", "enable_wind"): ("0", "false"),
    ("model", "self_collide"): ("", "0", "false"),
    ("link", "audio_source"): (),
    ("link", "enable_wind"): ("0", "false"),
    ("link", "self_collide"): ("", "0", "false"),
    ("link", "kinematic"): ("0", "false"),
    ("link", "light"): (),
    ("link", "particle_emitter"): (),
    ("link", "projector"): (),
    ("inertial", "fluid_added_mass"): (),
    ("spot", "falloff"): ("1", "1.0"),
    **{
        (workflow, f"{kind}_map"): ("",)
        for workflow in ("metal", "specular")
        for kind in ("environment", "ambient_occlusion", "normal", "emissive", "light")
    },
}

_TRUTH: Final = ("", "0", "1", "false", "true")
_OWN: Final = (MASSLESS, PRESERVED, TINTS)
"""Attributes that elements have that were converted from another format."""
_ANY: Final = Rule(free=True)
_OF_SENSOR: Final = Rule(children={"noise": RULES["noise"]}, free=True)
"""The element of a registered sensor, which its reader checks; any ``<noise>`` in it is of SDF."""
_COUNTS: Final = {"c": ((3, 4), "3 or 4 numbers"), "p": ((0, 6, 7), "6 numbers")}
"""The counts of numbers in a colour and in a pose, of which an empty one is none."""


def check_vocabulary(element: Element, notes: Notes) -> None:
    """Warn of unknown elements and attributes, those without an effect here, and values of a wrong kind."""
    _check_inside(element, RULES.get(element.tag, _ANY), None, notes)


def _check_inside(element: Element, rule: Rule, around: tuple[Element, Rule] | None, notes: Notes) -> None:
    if element.tag == "sensor" and not rule.free:
        rule = _with_registered(element, rule)
    if rule.free and not rule.children:
        return
    for child in element.children:
        if ":" in child.tag:
            continue
        inner = rule.children.get(child.tag)
        if inner is None and rule.free:
            _check_inside(child, rule, None, notes)
            continue
        if inner is None:
            hint = _place_of(child, element, rule, around)
            message = f"<{child.tag}> is not an element of <{element.tag}>: ignored{hint}"
            notes.warn(child, Code.NRP383, message, subject=child.tag)
            continue
        problems = [*_attributes(child, inner), *_value(child, inner)]
        if child.tag == "plugin":
            problems += _plugin(child, rule)
        for problem in problems or _without_effect(element, child):
            notes.warn(child, Code.NRP383, problem, subject=child.tag)
        if child.tag == "pose":
            _check_angles(child, notes)
        _check_inside(child, inner, (element, rule), notes)


def _with_registered(sensor: Element, rule: Rule) -> Rule:
    """Return the rule of a ``<sensor>`` with the elements of its own type and of all registered types."""
    added = dict.fromkeys([sensor.attributes.get("type", ""), *sensor_types()], _OF_SENSOR)
    return replace(rule, children={**added, **rule.children})


def _place_of(child: Element, parent: Element, rule: Rule, around: tuple[Element, Rule] | None) -> str:
    """Return the name that was probably meant, or the right parent of an element."""
    near = get_close_matches(child.tag, rule.children, n=1)
    if near:
        return f"; did you mean <{near[0]}>?"
    if around is not None and child.tag in around[1].children:
        return f"; it belongs in <{around[0].tag}>, beside <{parent.tag}>"
    holders = [name for name in rule.children if child.tag in rule.children[name].children]
    return f"; it belongs in <{holders[0]}>" if len(holders) == 1 else ""


def _attributes(element: Element, rule: Rule) -> Iterator[str]:
    """Yield the attributes that an element does not have, and misspelt words."""
    for name, text in element.attributes.items():
        if ":" in name or name.startswith("xmlns") or name in _OWN:
            continue
        if name not in rule.attributes:
            hint = did_you_mean(name, rule.attributes) if rule.attributes else ""
            yield f"<{element.tag}> has no attribute '{name}': ignored{hint}"
        elif (words := rule.attributes[name]) and text not in words and (hint := hint_if_close(text, words)):
            yield f"the {name} of <{element.tag}> is '{text}'{hint}"


def _value(element: Element, rule: Rule) -> Iterator[str]:
    """Yield a text on a value of the wrong kind; the readers refuse the values that they use."""
    text = element.text
    if rule.value == "b" and text.lower() not in _TRUTH:
        yield without_truth_value(element)
    elif rule.value == "c" or rule.value == "p" or rule.value.isdigit():
        counts, wanted = _COUNTS.get(rule.value) or _number_kind(int(rule.value))
        if not _are_numbers(text) or len(text.split()) not in counts:
            yield f"<{element.tag}> must hold {wanted}, not '{text}': ignored"
    elif not rule.value and not rule.free and text:
        yield f"the text '{text:.40}' in <{element.tag}>, which holds elements, is ignored"


def _plugin(plugin: Element, around: Rule) -> Iterator[str]:
    """Yield texts on a plugin's misspelt file, and on elements in it that belong beside it."""
    if problem := wrong_file(plugin):
        yield problem
    for child in plugin.children:
        beside = around.children.get(child.tag)
        if beside and child.children and (beside.free or beside.children.keys() >= _tags(child)):
            yield f"<{child.tag}> in a <plugin> is ignored; it belongs beside it"


def _tags(element: Element) -> set[str]:
    return {child.tag for child in element.children}


def _number_kind(count: int) -> tuple[tuple[int, ...], str]:
    return (count,), "a number" if count == 1 else f"{count} numbers"


def _are_numbers(text: str) -> bool:
    try:
        return not any(isnan(float(word)) for word in text.split())
    except ValueError:
        return False


def check_sensors(sensors: Iterable[Element], notes: Notes) -> None:
    """Warn of the parameters of registered sensors, which have been read, that their readers do not have."""
    for sensor in sensors:
        for element, message in ignored_parameters(sensor):
            notes.warn(element, Code.NRP383, message, subject=element.tag)


def ignored_parameters(sensor: Element) -> Iterator[tuple[Element, str]]:
    """Yield the elements that the reader of a registered sensor has not looked for, each with a message.

    Args:
        sensor: the ``<sensor>``, which has been read. In it, only the elements of registered sensors that are
            not of SDF are examined, without the ``<noise>`` in them.
    """
    registered = _with_registered(sensor, RULES["sensor"])
    for child in sensor.children:
        if child.tag in sensor.asked and registered.children.get(child.tag) is _OF_SENSOR:
            yield from _not_asked(child)


def _not_asked(holder: Element) -> Iterator[tuple[Element, str]]:
    for child in holder.children:
        if ":" in child.tag or child.tag in _OF_SENSOR.children:
            continue
        if child.tag in holder.asked:
            yield from _not_asked(child)
        else:
            hint = hint_if_close(child.tag, holder.asked)
            yield child, f"<{child.tag}> is not an element of <{holder.tag}>: ignored{hint}"


def check_names(element: Element) -> None:
    """Check that no name contains ``::``, which separates a nested model from its parts.

    Raises:
        SceneError: one does.
    """
    _check_names(element, RULES.get(element.tag, _ANY))


def _check_names(element: Element, rule: Rule) -> None:
    for child in element.children:
        inner = rule.children.get(child.tag, _ANY)
        if inner.free:
            continue
        if "::" in (name := child.attributes.get("name", "")):
            raise child.error(
                f"the name '{name}' must not contain '::', which separates scopes from SDF 1.8 on"
            )
        if child.tag != "state":
            _check_names(child, inner)


def _check_angles(pose: Element, notes: Notes) -> None:
    if pose.is_set("degrees") or pose.attributes.get("rotation_format", "euler_rpy") != "euler_rpy":
        return
    try:
        widest = max(map(abs, pose.numbers(6)[3:]))
    except SceneError:  # empty, or refused where it is read
        return
    if widest > ROUNDED_TURN_RAD:
        message = (
            f"the <pose> {pose.text} has an angle of {widest:g} rad, more than a turn; "
            'is it meant in degrees? In SDF <pose degrees="true"> reads it so; xacro has ${radians(...)}'
        )
        notes.warn(pose, Code.NRP381, message, subject=pose.text)


def _without_effect(parent: Element, child: Element) -> Iterator[str]:
    nothing_special = _NOT_SIMULATED.get((parent.tag, child.tag))
    if nothing_special is not None and child.text.lower() not in nothing_special:
        value = f" {child.text}" if child.text else ""
        yield f"<{child.tag}>{value} of a <{parent.tag}> is not simulated"
