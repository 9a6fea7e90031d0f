"""Whatever a file sets away from its default changes what is read of it, or is named in a finding.

The elements are those of SDF 1.12 (http://sdformat.org/spec) in sensors, surfaces, inertials and joints, with
their defaults; of each sensor as far as its type has them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path

import pytest

from nrp_core import read_scene
from nrp_core.findings import Code

_BOX = "<geometry><box><size>1 1 1</size></box></geometry>"
_MASS = "<inertial><mass>1</mass></inertial>"
_WORLD = '<sdf version="1.12"><world name="w"><model name="m">{}</model></world></sdf>'
_LINK = f'<link name="a"><inertial>%s</inertial><collision name="c">{_BOX}%s</collision>%s</link>'
_JOINT = (
    '<joint name="{0}" type="{1}"><parent>{2}</parent><child>{3}</child>{4}</joint><link name="{3}">'
    f'<pose>0.1 0 0 0 0 0</pose>{_MASS}</link>'
)  # fmt: skip

INERTIAL = (
    "mass=1 pose=0,0,0,0,0,0 inertia/ixx=1 inertia/ixy=0 inertia/ixz=0 inertia/iyy=1 inertia/iyz=0 "
    "inertia/izz=1 "
    + " ".join(f"fluid_added_mass/{one}{other}=0" for i, one in enumerate("xyzpqr") for other in "xyzpqr"[i:])
)
SURFACE = """
    bounce/restitution_coefficient=0 bounce/threshold=100000 friction/torsional/coefficient=1:0.5
    friction/torsional/use_patch_radius=true friction/torsional/patch_radius=0
    friction/torsional/surface_radius=0 friction/torsional/ode/slip=0 friction/ode/mu=1 friction/ode/mu2=1
    friction/ode/fdir1=0,0,0 friction/ode/slip1=0 friction/ode/slip2=0 friction/bullet/friction=1
    friction/bullet/friction2=1 friction/bullet/fdir1=0,0,0 friction/bullet/rolling_friction=1
    contact/collide_without_contact=false contact/collide_without_contact_bitmask=1
    contact/collide_bitmask=65535 contact/category_bitmask=65535 contact/poissons_ratio=0.3
    contact/elastic_modulus=-1 contact/ode/soft_cfm=0 contact/ode/soft_erp=0.2 contact/ode/kp=1e12
    contact/ode/kd=1 contact/ode/max_vel=0.01 contact/ode/min_depth=0 contact/bullet/soft_cfm=0
    contact/bullet/soft_erp=0.2 contact/bullet/kp=1e12 contact/bullet/kd=1 contact/bullet/split_impulse=true
    contact/bullet/split_impulse_penetration_threshold=-0.01 soft_contact/dart/bone_attachment=100
    soft_contact/dart/stiffness=100 soft_contact/dart/damping=10 soft_contact/dart/flesh_mass_fraction=0.05
"""
AXIS = """
    xyz=0,0,1 xyz@expressed_in=:a dynamics/damping=0 dynamics/friction=0 dynamics/spring_reference=0
    dynamics/spring_stiffness=0 limit/lower=-inf limit/upper=inf limit/effort=inf limit/velocity=inf
    limit/stiffness=1e8 limit/dissipation=1 mimic/multiplier=1:3 mimic/offset=0 mimic/reference=0
"""
PHYSICS = """
    physics/simbody/must_be_loop_joint=false physics/ode/cfm_damping=false
    physics/ode/implicit_spring_damper=false physics/ode/fudge_factor=0 physics/ode/cfm=0 physics/ode/erp=0.2
    physics/ode/bounce=0 physics/ode/max_force=0 physics/ode/velocity=0 physics/ode/limit/cfm=0
    physics/ode/limit/erp=0.2 physics/ode/suspension/cfm=0 physics/ode/suspension/erp=0.2
    physics/provide_feedback=false
"""
SENSOR = (
    "always_on=false update_rate=0 visualize=false topic=:t enable_metrics=false frame_id=:a pose=0,0,0,0,0,0"
)
NOISE = """
    mean=0 stddev=0 bias_mean=0 bias_stddev=0 dynamic_bias_stddev=0 dynamic_bias_correlation_time=0
    precision=0 @type=gaussian:none
"""
CAMERA = """
    triggered=false camera_info_topic=:t trigger_topic=:t horizontal_fov=1.047 image/width=320
    image/height=240 image/format=R8G8B8:L_INT8 image/anti_aliasing=4 clip/near=0.1 clip/far=100 save/path=:p
    noise/mean=0 noise/stddev=0 distortion/k1=0 distortion/k2=0 distortion/k3=0
    distortion/p1=0 distortion/p2=0 distortion/center=0.5,0.5 lens/intrinsics/fx=277 lens/intrinsics/fy=277
    lens/intrinsics/cx=160 lens/intrinsics/cy=120 lens/intrinsics/s=0 lens/projection/p_fx=277
    lens/projection/p_fy=277 lens/projection/p_cx=160 lens/projection/p_cy=120 lens/projection/tx=0
    lens/projection/ty=0 visibility_mask=4294967295:1 optical_frame_id=:a pose=0,0,0,0,0,0
"""
LENS = """
    lens/type=stereographic:equidistant lens/scale_to_hfov=true lens/cutoff_angle=1.5707
    lens/env_texture_size=256
"""
CUSTOM = """
    custom_function/c1=1 custom_function/c2=1 custom_function/c3=0 custom_function/f=1
    custom_function/fun=tan:sin
"""
LASER = """
    scan/horizontal/samples=640 scan/horizontal/resolution=1 scan/horizontal/min_angle=0
    scan/horizontal/max_angle=0 scan/vertical/samples=1 scan/vertical/resolution=1 scan/vertical/min_angle=0
    scan/vertical/max_angle=0 range/min=0 range/max=10 range/resolution=0 noise/mean=0 noise/stddev=0
    visibility_mask=4294967295:1
"""
IMU = """
    orientation_reference_frame/localization=CUSTOM:NED orientation_reference_frame/custom_rpy=0,0,0
    orientation_reference_frame/custom_rpy@parent_frame=:r orientation_reference_frame/grav_dir_x=1,0,0
    orientation_reference_frame/grav_dir_x@parent_frame=:r enable_orientation=true
"""
PER_AXIS = {
    "imu": ("angular_velocity/x", "angular_velocity/y", "angular_velocity/z", "linear_acceleration/x",
            "linear_acceleration/y", "linear_acceleration/z"),
    "force_torque": ("force/x", "force/y", "force/z", "torque/x", "torque/y", "torque/z"),
    "magnetometer": ("x", "y", "z"),
    "altimeter": ("vertical_position", "vertical_velocity"),
    "air_pressure": ("pressure",),
    "navsat": ("position_sensing/horizontal", "position_sensing/vertical", "velocity_sensing/horizontal",
               "velocity_sensing/vertical"),
}  # fmt: skip
OF_TYPE = {
    "imu": IMU,
    "force_torque": "frame=child:sensor measure_direction=child_to_parent:parent_to_child",
    "air_pressure": "reference_altitude=0",
    "altimeter": "",
    "magnetometer": "",
    "navsat": "",
    "logical_camera": "near=0 far=1 aspect_ratio=1 horizontal_fov=1",
    "sonar": "geometry=cone:sphere min=0 max=1 radius=0.5",
    "contact": "collision=:c topic=:t",
    "lidar": LASER,
    "camera": CAMERA,
}
"""The elements in the element of a type of sensors, with defaults; behind a colon is another valid value."""


def _away(default: str) -> str:
    """Return a value that is not a default, or the one behind its colon."""
    usual, colon, other = default.partition(":")
    if colon:
        return other
    if usual in ("true", "false"):
        return "false" if usual == "true" else "true"
    numbers = [0.5 if number == "inf" else -0.5 if number == "-inf" else _other(float(number))
               for number in usual.split(",")]  # fmt: skip
    return " ".join(f"{number:g}" for number in numbers)


def _other(number: float) -> float:
    larger = 2 * number if number.is_integer() else 1.5 * number
    return larger if number else 0.25


def _set(path: str, value: str, inside: str = "") -> str:
    """Return the elements along a path, the last with a value, or with it as an attribute after an ``@``."""
    path, _, attribute = path.partition("@")
    for tag in reversed(path.split("/")):
        value = (
            f'<{tag} {attribute}="{value}">{inside}</{tag}>'
            if attribute
            else f"<{tag}>{value}{inside}</{tag}>"
        )
        attribute = inside = ""
    return value


def _entries(table: str) -> Iterator[tuple[str, str]]:
    for entry in table.split():
        path, _, default = entry.partition("=")
        yield path, _away(default)


def _sensor(kind: str, content: str, beside: str = "") -> str:
    rate = "" if "<update_rate>" in beside else "<update_rate>7</update_rate>"
    tag = {"wideanglecamera": "camera", "depth_camera": "camera", "segmentation": "camera"}.get(kind, kind)
    held = f'<sensor name="s" type="{kind}">{rate}{beside}<{tag}>{content}</{tag}></sensor>'
    on_joint = kind == "force_torque"
    link = _LINK % ("<mass>1</mass>", "", "" if on_joint else held)
    return link + _JOINT.format("j", "revolute", "a", "b", _FIRST + held * on_joint)


Case = tuple[str, str, str]
"""The name of an element, a model without it, and one with it away from its default."""


def _inertials() -> Iterator[Case]:
    plain, auto = "<mass>1</mass>", _LINK.replace("<inertial>", '<inertial auto="true">')
    for path, value in _entries(INERTIAL):
        content = _set(path, value) if path == "mass" else plain + _set(path, value)
        yield path, _LINK % (plain, "", ""), _LINK % (content, "", "")
    for path, value in (("mass", "3"), ("density", "500")):
        yield path, auto % ("", "", ""), auto % (_set(path, value), "", "")
    yield "auto", _LINK % (plain, "", ""), auto % (plain, "", "")


def _surfaces() -> Iterator[Case]:
    for path, value in _entries(SURFACE):
        by_radius = "<use_patch_radius>0</use_patch_radius>" if path.endswith("surface_radius") else ""
        beside = by_radius + ("" if path.endswith("/patch_radius") else "<patch_radius>0.01</patch_radius>")
        parts = ["", _set(f"surface/{path}", value)]
        if "torsional" in path:
            parts = [
                _set("surface/friction/torsional", beside),
                parts[1].replace("<torsional>", f"<torsional>{beside}"),
            ]
        without, changed = (_LINK % ("<mass>1</mass>", part, "") for part in parts)
        yield path, without, changed


_FRAMES = _LINK.replace('name="a">', 'name="a"><pose>0 0 0 1 0 0</pose>') % ("<mass>1</mass>", "", "")
_LEADER = _JOINT.format("k", "revolute", "a", "z", "<axis><xyz>1 0 0</xyz></axis>")
_FIRST = "<axis><xyz>0 0 1</xyz></axis>"


def _joint(kind: str, content: str) -> str:
    return _LEADER + _FRAMES + _JOINT.format("j", kind, "a", "b", content)


def _joints() -> Iterator[Case]:
    for path, value in _entries(PHYSICS):
        yield path, _joint("revolute", _FIRST), _joint("revolute", _FIRST + _set(path, value))
    for path, kind in (
        ("thread_pitch", "screw"),
        ("screw_thread_pitch", "screw"),
        ("gearbox_ratio", "revolute"),
    ):
        yield path, _joint(kind, _FIRST), _joint(kind, _FIRST + _set(path, "2"))
    for (path, value), second in product(_entries(AXIS), (False, True)):
        without, changed = _axes(path, value)
        other = "<xyz>0 1 1</xyz>"
        bodies = [f"<axis>{other}</axis><axis2>{each}</axis2>" if second else
                  f"<axis>{each}</axis><axis2>{other}</axis2>" for each in (without, changed)]  # fmt: skip
        yield path, _joint("universal", bodies[0]), _joint("universal", bodies[1])


def _axes(path: str, value: str) -> tuple[str, str]:
    """Return the contents of an axis without an element, and with it where it has an effect."""
    tag, _, last = path.partition("/")
    if tag.startswith("xyz"):
        return "<xyz>1 0 1</xyz>", _set(path, value, "1 0 1" if "@" in path else "")
    if tag == "mimic":
        given = {"multiplier": "2", "offset": "0.1"}
        both = ("".join(_set(*each) for each in one.items()) for one in (given, given | {last: value}))
        without, changed = (f'<mimic joint="k">{each}</mimic>' for each in both)
    elif last == "spring_reference":
        stiff = "<dynamics><spring_stiffness>1</spring_stiffness>{}</dynamics>"
        without, changed = stiff.format(""), stiff.format(_set(last, value))
    else:
        without, changed = "", _set(path, value)
    return f"<xyz>1 0 0</xyz>{without}", f"<xyz>1 0 0</xyz>{changed}"


def _sensors() -> Iterator[Case]:
    for kind, table in OF_TYPE.items():
        for path, value in _entries(SENSOR):
            yield path, _sensor(kind, ""), _sensor(kind, "", _set(path, value))
        for path, value in _entries(table):
            changed = _set(path, value).replace("<noise>", '<noise type="gaussian">')
            if path.startswith("scan/vertical/m"):  # of one layer, no angle has an effect
                layers = "<scan><vertical><samples>2</samples>{}</vertical></scan>"
                without, changed = layers.format(""), layers.format(_set(path.rpartition("/")[2], value))
                yield path, _sensor(kind, without), _sensor(kind, changed)
            else:
                yield path, _sensor(kind, ""), _sensor(kind, changed)


def _noises() -> Iterator[Case]:
    for kind, places in PER_AXIS.items():
        for place, (path, value) in product(places, _entries(NOISE)):
            given = {"stddev": "1", "dynamic_bias_stddev": "1", "dynamic_bias_correlation_time": "1"}
            given = {tag: each for tag, each in given.items() if tag != path}
            model = "gaussian_quantized" if path == "precision" else "gaussian"
            before, after = (
                _set(place, f'<noise type="{model}">{"".join(_set(*each) for each in one.items())}</noise>')
                for one in (given, given if path == "@type" else given | {path: value})
            )
            after = after.replace("gaussian", value) if path == "@type" else after
            yield f"{place}/{path}", _sensor(kind, before), _sensor(kind, after)


def _cameras() -> Iterator[Case]:
    wide, custom = "wideanglecamera", "<type>custom</type><scale_to_hfov>false</scale_to_hfov>"
    for path, value in _entries(LENS):
        yield path, _sensor(wide, ""), _sensor(wide, _set(path, value))
    for path, value in _entries(CUSTOM):
        parts = ("", _set(path, value))
        before, after = (_sensor(wide, f"<lens>{custom}{part}</lens>") for part in parts)
        yield path, before, after
    for kind, path, value in (
        ("segmentation", "segmentation_type", "panoptic"), ("segmentation", "box_type", "3d"),
        ("depth_camera", "depth_camera/output", "points"), ("depth_camera", "depth_camera/clip/near", "0.3"),
        ("depth_camera", "depth_camera/clip/far", "7"),
    ):  # fmt: skip
        yield path, _sensor(kind, ""), _sensor(kind, _set(path, value))


@pytest.mark.one_of(3)
@pytest.mark.parametrize(
    ("cases", "number"),
    [(_inertials, 32), (_surfaces, 38), (_joints, 47), (_sensors, 140), (_noises, 176), (_cameras, 14)],
)
def test_each_element_of_the_specification_has_an_effect_or_a_finding(
    cases: Callable[[], Iterator[Case]], number: int, tmp_path: Path
) -> None:
    file = tmp_path / "room.sdf"
    read: dict[str, tuple[str, dict[str, int]]] = {}

    def outcome(model: str) -> tuple[str, dict[str, int]]:
        if model not in read:
            file.write_text(_WORLD.format(model))
            scene = read_scene(file)
            read[model] = scene.digest, {each.message: each.count for each in scene.warnings}
        return read[model]

    silent, every = [], list(cases())
    for path, without, changed in every:
        (digest, before), (other, after) = outcome(without), outcome(changed)
        tag = re.split("[/@]", path)[-1]
        new = [message for message, count in after.items() if before.get(message, 0) < count]
        if digest == other and not any(tag in message or "names the frame" in message for message in new):
            silent.append((path, changed))
    assert len(every) >= number
    assert silent == []


@pytest.mark.parametrize(
    "kind", ["air_speed", "air_flow", "boundingbox_camera", "dvl", "rfid", "rfidtag", "wireless_receiver"]
)
def test_a_sensor_that_is_not_simulated_is_one_finding(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "room.sdf"
    file.write_text(_WORLD.format(_sensor(kind, "<noise><stddev>1</stddev></noise><rate>1</rate>")))
    (finding,) = read_scene(file).warnings
    assert (finding.code, finding.subject) == (Code.NRP262, kind)
