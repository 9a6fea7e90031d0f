"""Domain randomisation: the scene of a seed, whose properties are drawn, for any engine.

An engine opens the drawn scene, so it is independent of this. A number depends on the
seed, the quantity and the name of the part only: further ranges and other parts do not change it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import Any, Final, TypeAlias

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.scene.devices import Noise, Pid
from nrp_core.scene.model import Link, Model, Scene
from nrp_core.scene.origin import Native
from nrp_core.scene.randomization import OPERATIONS, Draw, Randomization
from nrp_core.scene.rigid import Pose
from nrp_core.seeds import Seeds

Numbers: TypeAlias = tuple[float, ...]
Change: TypeAlias = Callable[[str, Numbers], Numbers]
"""Returns the new numbers of a part, given its name and those in the scene."""
SensorChange: TypeAlias = Callable[[Any, Callable[[Numbers], Numbers]], Any]
"""Returns a changed sensor, given the change of its numbers."""


def draw_scene(scene: Scene, seed: int) -> tuple[Scene, tuple[Draw, ...]]:
    """Return the scene of a seed, without ranges, and the drawn values.

    A scene without ranges is returned unchanged.
    """
    if not scene.randomize:
        return scene, ()
    streams, draws = Seeds(seed).child("world/randomize"), dict[tuple[str, str], Draw]()
    drawn = replace(scene, randomize=())

    def change(entries: Sequence[Randomization], part: str, nominal: Numbers) -> Numbers:
        entry = next((entry for entry in entries if entry.matches(part)), None)
        if entry is None:
            return nominal
        name = f"{entry.quantity}:{entry.pattern if entry.shared else part}"
        numbers = tuple(entry.sample(streams.stream(name), len(nominal)).tolist())
        draws[entry.quantity, part] = Draw(entry.quantity, part, entry.operation, numbers)
        return tuple(map(entry.applied, nominal, numbers))

    for quantity in OPERATIONS:
        if entries := [entry for entry in scene.randomize if entry.quantity == quantity]:
            drawn = _QUANTITIES[quantity].change(drawn, partial(change, entries))
    return drawn, tuple(draws.values())


def check_randomization(entry: Randomization, scene: Scene) -> None:
    """Refuse a range that draws nothing, or invalid values.

    Args:
        entry: the range.
        scene: the scene, with the ranges that are known already.

    Raises:
        SceneError: it matches no part, one that another range of the same quantity matches, or one whose
            value could be too low, or scales only zeros.
    """
    quantity, found = _QUANTITIES[entry.quantity], dict[str, list[float]]()

    def collect(part: str, nominal: Numbers) -> Numbers:
        found.setdefault(part, []).extend(nominal)
        return nominal

    quantity.change(scene, collect)
    matched = {part: numbers for part, numbers in found.items() if entry.matches(part)}
    if not matched:
        hint = did_you_mean(entry.pattern, found) if found else "; there is none"
        raise SceneError(f"'{entry.pattern}' matches no {quantity.parts}{hint}")
    others = [other for other in scene.randomize if other.quantity == entry.quantity]
    for part, numbers in matched.items():
        if any(other.matches(part) for other in others):
            raise SceneError(f"two patterns of '{entry.quantity}' match '{part}'")
        lowest = min(entry.applied(nominal, entry.low) for nominal in numbers)
        if lowest < quantity.least or (quantity.is_positive and lowest == 0):
            bound = f"{'more than' if quantity.is_positive else 'at least'} {quantity.least:g}"
            raise SceneError(f"{entry.quantity} of '{part}' could be {lowest:g}; it is {bound}")
    if entry.operation == "scale" and not any(map(any, matched.values())):
        raise SceneError(
            f"{entry.quantity} of '{entry.pattern}' is 0, which 'scale' does not change: use 'range'"
        )


@dataclass(frozen=True, slots=True)
class _Quantity:
    """A property that can be drawn.

    Args:
        parts: the kind of parts that have it, and the form of their names, for messages.
        change: returns a scene in which it is changed.
        least: its least value.
        is_positive: whether it is also more than that.
    """

    parts: str
    change: Callable[[Scene, Change], Scene]
    least: float = -inf
    is_positive: bool = False


def _of_models(changed: Callable[[Model, Change], Model]) -> Callable[[Scene, Change], Scene]:
    """Return the change of a scene, given that of a model."""
    return lambda scene, change: replace(scene, models=tuple(changed(one, change) for one in scene.models))


def _with_masses(model: Model, change: Change) -> Model:
    """Return a model with other masses; inertia is proportional to mass, as of other densities."""

    def changed(link: Link) -> Link:
        if link.inertial is None or not link.inertial.mass or model.static:
            return link
        (mass,) = change(f"{model.name}/{link.name}", (link.inertial.mass,))
        xx, yy, zz, xy, xz, yz = (each * (mass / link.inertial.mass) for each in link.inertial.inertia)
        return replace(link, inertial=replace(link.inertial, mass=mass, inertia=(xx, yy, zz, xy, xz, yz)))

    return replace(model, links=tuple(map(changed, model.links)))


def _with_friction(model: Model, change: Change) -> Model:
    """Return a model with other friction, also where elements for an engine state it of a link's shapes."""

    def rubs(link: str, friction: float) -> float:
        return change(f"{model.name}/{link}", (friction,))[0]

    def changed(link: Link) -> Link:
        shapes = (replace(one, friction=rubs(link.name, one.friction)) for one in link.collisions)
        return replace(link, collisions=tuple(shapes))

    def stated(element: Native) -> Native:
        link, written = element.attribute("link"), element.attribute("friction")
        if element.tag != "geom" or link is None or not written:
            return element
        sliding, *others = written.split()
        friction = " ".join([f"{rubs(link, float(sliding)):.17g}", *others])
        given = {**dict(element.attributes), "friction": friction}
        return replace(element, attributes=tuple(given.items()))

    links, native = map(changed, model.links), map(stated, model.native)
    return replace(model, links=tuple(links), native=tuple(native))


def _with_gains(model: Model, change: Change) -> Model:
    """Return a model with other gains of the controllers that have some."""

    def changed(name: str, gains: Pid) -> Pid:
        p, i, d = change(f"{model.name}/{name}", (gains.p, gains.i, gains.d))
        return replace(gains, p=p, i=i, d=d)

    def led(leader: Any) -> Any:
        return replace(leader, gains=tuple((joint, changed(joint, gains)) for joint, gains in leader.gains))

    return replace(
        model,
        controllers=tuple(
            each
            if each.gains is None or each.kind == "effort"
            else replace(each, gains=changed(each.joint, each.gains))
            for each in model.controllers
        ),
        trajectory_controllers=tuple(map(led, model.trajectory_controllers)),
        group_controllers=tuple(
            each if each.kind == "effort" else led(each) for each in model.group_controllers
        ),
        pair_controllers=tuple(
            each if each.gains is None else replace(each, gains=changed(each.name, each.gains))
            for each in model.pair_controllers
        ),
    )


def _with_lights(scene: Scene, change: Change) -> Scene:
    """Return a scene with lights of another brightness."""
    lights = []
    for light in scene.lights:
        (factor,) = change(light.name, (1.0,))
        red, green, blue = (factor * each for each in light.diffuse[:3])
        lights.append(replace(light, diffuse=(red, green, blue, light.diffuse[3])))
    return replace(scene, lights=tuple(lights))


def _of_sensors(changed: SensorChange) -> Callable[[Scene, Change], Scene]:
    """Return the change of a scene, given that of a sensor by numbers."""

    def of_model(model: Model, change: Change) -> Model:
        def of_link(link: Link) -> Link:
            sensors = []
            for sensor in link.sensors:
                name = f"{model.name}/{link.name}/{sensor.name}"
                sensors.append(changed(sensor, partial(change, name)))
            return replace(link, sensors=tuple(sensors))

        return replace(model, links=tuple(map(of_link, model.links)))

    return _of_models(of_model)


def _placed(offset: Callable[[float, float, float], Pose]) -> SensorChange:
    """Return the change of where a sensor is, by an offset in its frame; one behind a lens moves with it."""

    def changed(sensor: Any, change: Callable[[Numbers], Numbers]) -> Any:
        if hasattr(sensor, "optics"):
            return replace(sensor, optics=changed(sensor.optics, change))
        if not hasattr(sensor, "pose"):
            return sensor
        numbers = change((0.0, 0.0, 0.0))
        return replace(sensor, pose=sensor.pose @ offset(*numbers)) if any(numbers) else sensor

    return changed


def _noisy(field: str) -> SensorChange:
    """Return the change of a field of all noises of a sensor."""

    def changed(sensor: Any, change: Callable[[Numbers], Numbers]) -> Any:
        given = {name: getattr(sensor, name) for name in ("noise", *sensor.noises)}
        noises: dict[str, Noise] = {
            name: noise.changed(lambda one: replace(one, **{field: change((getattr(one, field),))[0]}))
            for name, noise in given.items()
            if noise is not None
        }
        return replace(sensor, **noises)

    return changed


_SENSOR: Final = "sensor, named MODEL/LINK/SENSOR"
_QUANTITIES: Final = {
    "mass": _Quantity("link with a mass that moves, named MODEL/LINK", _of_models(_with_masses), 0.0, True),
    "friction": _Quantity("link with collisions, named MODEL/LINK", _of_models(_with_friction), 0.0),
    "gains": _Quantity("joint whose controller has gains, named MODEL/JOINT", _of_models(_with_gains), 0.0),
    "light": _Quantity("light", _with_lights, 0.0),
    "sensor_position": _Quantity(_SENSOR, _of_sensors(_placed(lambda x, y, z: Pose((x, y, z))))),
    "sensor_orientation": _Quantity(_SENSOR, _of_sensors(_placed(partial(Pose.from_rpy, (0.0, 0.0, 0.0))))),
    "sensor_noise": _Quantity(_SENSOR, _of_sensors(_noisy("stddev")), 0.0),
    "sensor_bias": _Quantity(_SENSOR, _of_sensors(_noisy("mean"))),
}
