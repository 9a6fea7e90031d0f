"""Implausible values of robots and rooms: valid, but far from any real object; most are in the wrong unit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from math import degrees, hypot, inf, isfinite, pi, radians
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import SceneError, did_you_mean
from nrp_core.world.rigid import Pose, Vector, matrix_of
from nrp_core.world.scene.devices import MountedSensor, Noise, View
from nrp_core.world.scene.implausible_joints import of_joints, of_slides
from nrp_core.world.scene.implausible_links import has_dense_link, of_links
from nrp_core.world.scene.implausible_looks import of_looks
from nrp_core.world.scene.implausible_shapes import box_around, of_radii, solid_or_seen, without_strays
from nrp_core.world.scene.implausible_twins import of_twins
from nrp_core.world.scene.model import Geometry, Light, Link, Model, Plane, Scene

_DENSEST: Final = 22_590.0
"""Density of osmium, kg/m^3: CRC Handbook of Chemistry and Physics, the densest of all elements."""
_LIGHTEST: Final = 0.05
"""A density below that of hydrogen at room temperature, 0.08 kg/m^3 (the same source)."""
_STRONGEST: Final = 25.0
"""Gravity of Jupiter at one bar, 24.79 m/s^2: NASA Planetary Fact Sheet, the strongest of all planets."""
FASTEST_HZ: Final = 5e4
"""More often than any sensor of robots; inertial sensors reach 32 kHz (ICM-42688-P data sheet)."""
_UPSIDE_DOWN: Final = 0.5
"""A plane faces downward if its normal points below the horizon by 30 degrees or more; others are walls."""
_NEAR_M: Final = 1.0
_NARROWEST: Final = 0.02
"""The smallest field of view, rad: one degree is that of a telescope."""
_WIDEST: Final = 3.0
"""The largest field of view, rad, of an image in perspective: half of its pixels show the last 7 degrees."""
_FARTHEST_M: Final = 2e4
"""The longest range of a sensor of distances, m: laser rangefinders reach 20 km."""
_FINEST: Final = 1e-4
"""The smallest angle between two beams, rad; the finest scanners have 0.0009 (0.05 degrees)."""
_NOISY: Final = 0.5
"""The largest noise as a share of the largest value: beyond it a measurement says hardly anything."""
_FASTEST_TURN: Final = radians(4000)
"""The widest range of gyroscopes, rad/s (ISM330DHCX data sheet: 4000 degrees per second)."""
_SHORT: Final = 0.1
"""The smallest range of a sensor of distances, in sizes of the robot."""
_OPTICAL: Final = matrix_of(Pose.from_rpy((0.0, 0.0, 0.0), -pi / 2, 0.0, -pi / 2))[:, :3]
_ROUNDED: Final = 0.01
"""How far a rounded angle is off, rad."""
_UPRIGHT: Final = 0.9
_SENSOR_TIMES: Final = 10.0
"""How many times a robot's size a sensor is away from its link if its place is in millimetres."""


def implausible(scene: Scene, robots: Iterable[str]) -> Iterator[tuple[str | None, str]]:
    """Yield each implausible value as a sentence, with the robot that it belongs to.

    Args:
        scene: the scene.
        robots: names of its robots; of other models only the sensors are checked.
    """
    yield from ((None, sentence) for sentence in (*_of_gravity(scene.gravity), *_of_lights(scene.lights)))
    names = set(robots)
    for whole in scene.models:
        owner, model = (whole.name if whole.name in names else None), whole
        if not whole.static:
            with suppress(SceneError):  # a mesh cannot be read, which is reported where it is needed
                said, model = without_strays(whole)
                yield from [(owner, sentence) for sentence in said]
        yield from (
            (owner, sentence)
            for sentence in (
                *_of_measurements(model),
                *of_radii(whole),
                *of_twins(model),
                *_of_ground(model),
            )
        )
        if owner is not None:
            found = (*_of_rest(model), *_of_loose_links(model), *of_joints(model), *_of_sizes(model))
            yield from ((owner, sentence) for sentence in found)
        with suppress(SceneError):
            yield from [(owner, sentence) for sentence in of_looks(model)]
        if not model.static:
            with suppress(SceneError):
                yield from [(owner, sentence) for sentence in of_links(model)]
                yield from [(owner, sentence) for sentence in _of_furniture(model) if owner is None]


def _of_gravity(gravity: Vector) -> Iterator[str]:
    x, y, z = gravity
    owner = f"gravity is {x:g} {y:g} {z:g} m/s^2"
    if z > 0:
        yield f"{owner}: it points upward"
    elif hypot(x, y) > -z:
        yield f"{owner}: it points to the side"
    if hypot(x, y, z) > _STRONGEST:
        yield f"{owner}, more than on Jupiter"
    elif hypot(x, y, z) == 1.0:
        yield f"{owner}; is it meant in g, which is 9.8 m/s^2?"


def _of_lights(lights: Iterable[Light]) -> Iterator[str]:
    """Yield a sentence if nothing shines on a scene, or only from below."""
    lights = tuple(lights)
    if lights and not any(any(light.diffuse[:3]) for light in lights):
        yield "the lights of the room are black: nothing is lit"
    suns = [light for light in lights if light.kind == "directional"]
    if suns and len(suns) == len(lights) and all(light.direction[2] > 0 for light in suns):
        x, y, z = suns[0].direction
        yield f"the light '{suns[0].name}' shines upward, to {x:g} {y:g} {z:g}: no side that is seen is lit"


def _of_measurements(model: Model) -> Iterator[str]:
    for sensor in (sensor for link in model.links for sensor in link.sensors):
        owner = f"the sensor '{sensor.name}' of '{model.name}'"
        if sensor.rate_hz > FASTEST_HZ:
            yield f"{owner} measures {sensor.rate_hz:g} times a second"
        # the largest value of a measurement, with its name
        largest = [(1.0, "full brightness")] if sensor.view is not None else []
        largest += [(one, "its range") for one in [getattr(sensor, "range_max", inf)] if isfinite(one)]
        noise = max(abs(sensor.noise.mean), sensor.noise.stddev)
        for field in sensor.noises:
            own: Noise | None = getattr(sensor, field)
            largest_turn = 0.0 if own is None else max(abs(own.mean), own.stddev)
            if largest_turn > _FASTEST_TURN:
                yield (
                    f"the noise of the turn rates of {owner} is {largest_turn:g} rad/s, and gyroscopes "
                    f"measure up to {_FASTEST_TURN:.3g} rad/s"
                )
        for limit, what in largest:
            if noise > _NOISY * limit:
                yield f"the noise of {owner} is {noise:g}, and {what} is {limit:g}"
    for link in model.links:
        yield from _of_contacts(model, link)
    yield from _of_topics(model)


def _of_topics(model: Model) -> Iterator[str]:
    """Yield the topics with blanks that the file writes; by default a topic holds the names of parts."""
    sensors = [sensor for link in model.links for sensor in link.sensors]
    named = [model.name]
    for parts in (model.links, model.joints, sensors):
        named += [part.name for part in parts]
    topics = [topic for sensor in sensors for topic in sensor.topics]
    topics += [controller.topic for controller in model.controllers]
    for topic in dict.fromkeys(topics):
        if " " in topic and not any(" " in name for name in named):
            yield f"the topic '{topic}' of '{model.name}' has a blank, which a name in ROS cannot have"


def _of_contacts(model: Model, link: Link) -> Iterator[str]:
    """Yield the contact sensors of a link that feel a shape that the link does not have."""
    shapes = [one.name for one in link.collisions]
    elsewhere = {f"{other.name}::{one.name}" for other in model.links for one in other.collisions}
    for sensor in link.sensors:
        for name in getattr(sensor, "collisions", ()):
            if name not in shapes and name not in elsewhere:
                hint = did_you_mean(name, shapes) if shapes else "; it has none"
                yield (
                    f"the sensor '{sensor.name}' of '{model.name}' feels the collision '{name}', which its "
                    f"link '{link.name}' does not have{hint}"
                )


def _of_ground(model: Model) -> Iterator[str]:
    """Yield the planes whose solid side is above them; things above fall through or are thrown out."""
    for link in model.links:
        for one in link.collisions:
            up = matrix_of(model.pose @ link.pose @ one.pose)[2, 2]
            if isinstance(one.geometry, Plane) and up < -_UPSIDE_DOWN:
                yield f"the plane '{one.name}' of '{model.name}' faces downward: things above it are inside"


def _of_rest(model: Model) -> Iterator[str]:
    if model.static:
        yield f"the robot '{model.name}' is static: nothing moves it, and no drive can"


def _of_loose_links(model: Model) -> Iterator[str]:
    """Yield the links of a robot that no joint holds; WORLD holds those that are fixed to the world."""
    if not model.joints:
        return
    jointed = {name for joint in model.joints for name in (joint.parent, joint.child)} | {model.links[0].name}
    for link in model.links:
        if link.name not in jointed:
            yield f"the link '{link.name}' of '{model.name}' is a body of its own: no joint holds it"


def _of_sizes(model: Model) -> Iterator[str]:
    try:
        touched = _size(
            (link.pose @ one.pose, one.geometry) for link in model.links for one in link.collisions
        )
        shown = _size((link.pose @ one.pose, one.geometry) for link in model.links for one in link.visuals)
    except SceneError:
        return  # a mesh cannot be read, which is reported where it is needed
    if touched is None or not touched.min() > 0:
        return
    around = touched if shown is None else np.maximum(touched, shown)
    size_m = float(np.linalg.norm(around))
    yield from _of_sensors(model, size_m)
    yield from of_slides(model, _largest_link_m(model))
    for link in model.links:
        away_m = 0.0 if link.inertial is None else hypot(*link.inertial.pose.position)
        if away_m > _SENSOR_TIMES * size_m:
            yield (
                f"the centre of mass of the link '{link.name}' of '{model.name}' is {away_m:.3g} m from the "
                f"link, and the robot {size_m:.3g} m large; is it meant in mm?"
            )
    yield from _of_density(model, around)


def _largest_link_m(model: Model) -> float:
    """Return the size of the largest link, m: the robot itself may be large by a wrong pose."""
    boxes = (_size((one.pose, one.geometry) for one in solid_or_seen(link)) for link in model.links)
    return max((float(np.linalg.norm(one)) for one in boxes if one is not None), default=inf)


def _of_furniture(model: Model) -> Iterator[str]:
    """Yield that a model of the room is too light for its size; heavy links are reported one by one."""
    shapes = [(link, one) for link in model.links for one in solid_or_seen(link)]
    around = _size((link.pose @ one.pose, one.geometry) for link, one in shapes)
    if around is not None and 0 < _mass(model) < _LIGHTEST * around.prod():
        yield from _of_density(model, around)


def _mass(model: Model) -> float:
    return sum(link.inertial.mass for link in model.links if link.inertial is not None)


def _of_density(model: Model, around: FloatArray) -> Iterator[str]:
    """Yield that a model is too heavy or too light for the sides of the box around it, m."""
    mass = _mass(model)
    density = mass / float(around.prod())
    is_dense = density > _DENSEST and not has_dense_link(model)
    if is_dense or 0 < density < _LIGHTEST:
        than = "more than osmium" if is_dense else "less than hydrogen"
        meant = "is its mass meant in g?" if is_dense else "are its lengths meant in mm?"
        yield (
            f"'{model.name}' weighs {mass:.3g} kg in a box of {' x '.join(f'{one:.2g}' for one in around)} m "
            f"around it: {density:.2g} kg/m^3, {than}; {meant}"
        )


def _of_sensors(model: Model, size_m: float) -> Iterator[str]:
    for link in model.links:
        for sensor in link.sensors:
            owner = f"'{sensor.name}' of '{model.name}'"
            yield from _of_view(f"the camera {owner}", sensor, size_m)
            yield from _of_beams(owner, sensor, size_m)
            reach_m = getattr(sensor, "range_max", inf)
            if reach_m < _SHORT * size_m and reach_m < _SHORT * _largest_link_m(model):
                yield (
                    f"the sensor {owner} measures up to {reach_m:g} m, and the robot is {size_m:.3g} m "
                    "large; is its range meant in km?"
                )
            yield from _of_optics(f"the camera {owner}", sensor, link)
            yield from _of_touch(owner, sensor, link)
            pose = getattr(sensor, "pose", None)
            away_m = 0.0 if pose is None else hypot(*pose.position)
            if away_m > _SENSOR_TIMES * size_m:
                yield (
                    f"the sensor {owner} is {away_m:.3g} m from its link, and the robot {size_m:.3g} m "
                    "large; is its pose meant in mm?"
                )


def _of_optics(owner: str, sensor: MountedSensor, link: Link) -> Iterator[str]:
    """Yield that a camera on an upright link is turned as if it looked along z, and so lies on its side."""
    if sensor.view is None or matrix_of(link.pose)[2, 2] < _UPRIGHT:
        return
    if np.abs(matrix_of(sensor.view.pose)[:, :3] - _OPTICAL).max() < _ROUNDED:
        yield (
            f"{owner} is turned by -pi/2 0 -pi/2 as an optical frame, and cameras look along x: "
            "it looks along -y of its link, and the top of its images is along x"
        )


def _of_touch(owner: str, sensor: MountedSensor, link: Link) -> Iterator[str]:
    """Yield that a contact sensor of a whole link has nothing that can touch anything."""
    if sensor.tag == "contact" and not getattr(sensor, "collisions", ()) and not link.collisions:
        yield (
            f"the contact sensor {owner} is on the link '{link.name}', which has no collision shape: it "
            "never reports a contact"
        )


def _of_view(owner: str, sensor: MountedSensor, size_m: float) -> Iterator[str]:
    view: View | None = getattr(sensor, "view", None)
    if view is None:
        return
    if view.far < min(size_m, _NEAR_M):
        yield (
            f"{owner} sees {view.far:g} m far, and the robot is {size_m:.3g} m large; is <far> meant in km?"
        )
    elif view.near > max(size_m, _NEAR_M):
        yield f"{owner} sees nothing nearer than {view.near:g} m, and the robot is {size_m:.3g} m large"
    if view.horizontal_fov < _NARROWEST:
        seen = f"{view.horizontal_fov:g} rad, which is {degrees(view.horizontal_fov):.2g} degrees"
        yield f"{owner} sees {seen}"
    elif view.horizontal_fov > _WIDEST:
        yield (
            f"{owner} has a field of view of {view.horizontal_fov:g} rad: an image in perspective of nearly "
            "half of the surroundings is all border"
        )


def _of_beams(owner: str, sensor: MountedSensor, size_m: float) -> Iterator[str]:
    steps = getattr(sensor, "samples", 1) - 1
    first, last = getattr(sensor, "angle_min", 0.0), getattr(sensor, "angle_max", 0.0)
    if steps > 1 and 0 < last - first < steps * _FINEST:
        between = f"{last - first:.2g} rad: from {first:.6g} to {last:.6g}"
        yield f"the {steps + 1} beams of {owner} are within {between}"
    reach_m = getattr(sensor, "range_max", inf)
    least_m = getattr(sensor, "range_min", 0.0)
    if least_m > max(size_m, _NEAR_M):
        yield (
            f"the sensor {owner} measures nothing nearer than {least_m:g} m, and the robot is {size_m:.3g} m "
            "large"
        )
    if _FARTHEST_M < reach_m < inf:
        yield f"the sensor {owner} measures up to {reach_m:g} m; is its range meant in mm?"


def _size(shapes: Iterable[tuple[Pose, Geometry]]) -> FloatArray | None:
    """Return the sides of the box around bounded shapes, m."""
    box = box_around(shapes)
    return None if box is None else box[1] - box[0]
