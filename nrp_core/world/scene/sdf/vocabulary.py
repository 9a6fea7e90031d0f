"""The elements of SDF 1.4 to 1.12, and those with an effect that is not simulated.

An element that is neither read nor listed here causes a warning, so that typing errors are found. Elements of
other namespaces (``gz:...``) are accepted, as the specification requires.
"""

from __future__ import annotations

from collections.abc import Collection
from difflib import get_close_matches
from typing import Final

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.world.rigid.pose import ROUNDED_TURN_RAD
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.parameters import without_truth_value
from nrp_core.world.scene.reading.xml import Element

_CHILDREN = {
    "sdf": "world model actor light state",
    "world": "audio wind include gravity magnetic_field atmosphere gui physics scene light frame joint model "
    "actor plugin road spherical_coordinates state population",
    "model": "static self_collide allow_auto_disable frame pose link joint plugin gripper include model "
    "enable_wind",
    "include": "uri name pose static placement_frame plugin namespace",
    "frame": "pose",
    "wind": "linear_velocity",
    "link": "gravity enable_wind self_collide kinematic must_be_base_link velocity_decay frame pose inertial "
    "collision visual sensor projector audio_sink audio_source battery light particle_emitter plugin",
    "velocity_decay": "linear angular",
    "inertial": "mass inertia pose frame density auto_inertia_params fluid_added_mass",
    "inertia": "ixx ixy ixz iyy iyz izz",
    "collision": "laser_retro max_contacts frame pose geometry surface density auto_inertia_params",
    "visual": "cast_shadows laser_retro transparency visibility_flags meta frame pose material geometry "
    "plugin",
    "image": "width height format anti_aliasing uri scale threshold height granularity",
    "geometry": "empty box capsule cone cylinder ellipsoid heightmap image mesh plane polyline sphere",
    "box": "size",
    "sphere": "radius",
    "cylinder": "radius length",
    "capsule": "radius length",
    "cone": "radius length",
    "ellipsoid": "radii",
    "plane": "normal size",
    "mesh": "uri scale submesh convex_decomposition",
    "submesh": "name center",
    "material": "script shader render_order lighting ambient diffuse specular shininess emissive "
    "double_sided pbr",
    "pbr": "metal specular",
    "metal": "albedo_map roughness roughness_map metalness metalness_map environment_map "
    "ambient_occlusion_map normal_map emissive_map light_map",
    "specular": "albedo_map specular_map glossiness glossiness_map environment_map ambient_occlusion_map "
    "normal_map emissive_map light_map",
    "surface": "bounce friction contact soft_contact",
    "friction": "torsional ode bullet",
    "joint": "parent child gearbox_ratio gearbox_reference_body thread_pitch screw_thread_pitch axis axis2 "
    "physics frame pose sensor",
    "axis2": "initial_position xyz use_parent_model_frame dynamics limit mimic",
    "axis": "initial_position xyz use_parent_model_frame dynamics limit mimic",
    "mimic": "multiplier offset reference",
    "dynamics": "damping friction spring_reference spring_stiffness",
    "limit": "lower upper effort velocity stiffness dissipation",
    "sensor": "always_on update_rate visualize enable_metrics topic frame_id gz_frame_id ignition_frame_id "
    "frame pose plugin air_flow "
    "air_pressure air_speed altimeter camera contact dvl force_torque gps imu lidar logical_camera "
    "magnetometer navsat ray rfid rfidtag sonar transceiver event_camera retina",
    "camera": "triggered camera_info_topic trigger_topic optical_frame_id horizontal_fov image clip save "
    "depth_camera segmentation_type box_type noise distortion lens visibility_mask pose frame",
    "clip": "near far",
    "lens": "type scale_to_hfov custom_function cutoff_angle env_texture_size intrinsics projection",
    "custom_function": "c1 c2 c3 f fun",
    "intrinsics": "fx fy cx cy s",
    "event_camera": "threshold spread",
    "retina": "centre surround gain baseline sustained adaptation",
    "sonar": "min max radius geometry",
    "lidar": "scan range noise visibility_mask",
    "ray": "scan range noise visibility_mask",
    "scan": "horizontal vertical",
    "horizontal": "samples resolution min_angle max_angle noise",
    "vertical": "samples resolution min_angle max_angle noise",
    "range": "min max resolution",
    "imu": "orientation_reference_frame angular_velocity linear_acceleration enable_orientation noise topic",
    "altimeter": "vertical_position vertical_velocity",
    "air_pressure": "reference_altitude pressure",
    "navsat": "position_sensing velocity_sensing",
    "gps": "position_sensing velocity_sensing",
    "logical_camera": "near far aspect_ratio horizontal_fov",
    "force_torque": "frame measure_direction force torque",
    "light": "cast_shadows intensity diffuse specular attenuation direction spot frame pose visualize "
    "light_on",
    "spot": "inner_angle outer_angle falloff",
}
_KNOWN = {parent: frozenset(children.split()) for parent, children in _CHILDREN.items()}

# their contents are free, read elsewhere, or not used here
_OPAQUE = ("actor", "gui", "physics", "plugin", "population", "scene", "state")

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


_FLAGS: Final = frozenset(
    {
        "always_on", "allow_auto_disable", "cast_shadows", "double_sided", "enable_metrics",
        "enable_orientation", "enable_wind", "gravity", "kinematic", "light_on", "self_collide", "static",
        "use_parent_model_frame", "visualize",
    }
)  # fmt: skip
"""Elements that are true or false; those that are used are refused where they are read."""
_TRUTH: Final = ("", "0", "1", "false", "true")


def check_vocabulary(element: Element, notes: Notes) -> None:
    """Warn, once for each kind, of elements that are unknown or have no effect here."""
    known = _KNOWN.get(element.tag)
    for child in element.children:
        if known is not None and ":" not in child.tag:
            _check(element, child, known, notes)
        if child.tag == "pose":
            _check_angles(child, notes)
        if child.tag not in _OPAQUE:
            check_vocabulary(child, notes)


def check_names(element: Element) -> None:
    """Check that no name contains ``::``, which separates a nested model from its parts.

    Raises:
        SceneError: one does.
    """
    for child in element.children:
        if (name := child.attributes.get("name", "")) and "::" in name and child.tag in _CHILDREN:
            raise child.error(
                f"the name '{name}' must not contain '::', which separates scopes from SDF 1.8 on"
            )
        if child.tag not in _OPAQUE:
            check_names(child)


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
        notes.warn(pose, Code.NRP298, message, subject=pose.text)


def _check(parent: Element, child: Element, known: Collection[str], notes: Notes) -> None:
    if child.tag not in known:
        near = get_close_matches(child.tag, known, n=1)
        hint = f"; did you mean <{near[0]}>?" if near else ""
        notes.warn(
            child,
            Code.NRP263,
            f"<{child.tag}> is not an element of <{parent.tag}>: ignored{hint}",
            subject=child.tag,
        )
        return
    if child.tag in _FLAGS and child.text.lower() not in _TRUTH and parent.tag != "world":
        notes.warn(child, Code.NRP263, without_truth_value(child), subject=child.tag)
        return
    nothing_special = _NOT_SIMULATED.get((parent.tag, child.tag))
    if nothing_special is not None and child.text.lower() not in nothing_special:
        value = f" {child.text}" if child.text else ""
        notes.warn(
            child,
            Code.NRP263,
            f"<{child.tag}>{value} of a <{parent.tag}> is not simulated",
            subject=child.tag,
        )
