"""Lengths, poses and time steps of models that are probably in another unit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from math import dist, hypot, inf
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.checks.examined import ExaminedExperiment, checks_experiment
from nrp_core.clock import NS_PER_MS, milliseconds
from nrp_core.errors import SceneError
from nrp_core.experiment.making.prepare import place_of_step
from nrp_core.findings import Code, Finding
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.model import Collision, Link, Model, Visual
from nrp_core.scene.rigid import Pose
from nrp_core.scene.tessellation import box_around, shapes_of

LEAST_DENSITY: Final = 1e-3
"""Density of a robot, kg/m^3, below which its lengths are in mm; those of flies and toys are above 0.008."""
UNIT_RATIOS: Final = (80.0, 125.0), (800.0, 1250.0)
"""Ratios of two sizes of the same form if one is in cm or mm and the other in m."""
THINNEST_M: Final = 1e-3
FAR_LINK: Final = 100.0
"""Distance between two jointed links, in sizes of the largest link."""
FAR_PART: Final = 10.0
"""Distance of a sensor, shape or centre of mass from its link, in sizes of all shapes together."""
MAX_STEPS: Final = 1000
"""Steps of a physics engine in one step of the loop; the smallest robots need a hundred."""
LONGEST_STEP_NS: Final = 10 * NS_PER_MS
"""The longest step of Gymnasium's models with contacts; Gazebo takes 1 ms and MuJoCo 2 ms."""


@checks_experiment
def check_lengths(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Check sizes and places in the models of a scene against each other."""
    for model in examined.models:
        with suppress(SceneError):  # a mesh cannot be read, which the reader reports
            for code, message in unlikely_lengths(
                model, is_robot=model.name in examined.experiment.world.robots
            ):
                yield examined.warning(code, message, *examined.keys_of(model.name))


def unlikely_lengths(model: Model, *, is_robot: bool) -> Iterator[tuple[Code, str]]:
    """Yield the code and the message of each length or place that is probably in another unit.

    Args:
        model: the model.
        is_robot: whether its mass is that of its shapes; other models may be dummies without weight.

    Raises:
        SceneError: a mesh cannot be read.
    """
    mismatched = [sentence for link in model.links for sentence in _mismatched_shapes(link, model)]
    if mismatched:
        more = f" (and {len(mismatched) - 1} more links)" if len(mismatched) > 1 else ""
        yield Code.NRP371, mismatched[0] + more
        return
    if model.static:
        return
    yield from ((Code.NRP381, sentence) for sentence in (*_distant_links(model), *_distant_parts(model)))
    if is_robot:
        yield from ((Code.NRP371, sentence) for sentence in _low_density(model))


def _mismatched_shapes(link: Link, model: Model) -> Iterator[str]:
    """Yield that the visuals and collision shapes of a link differ by a unit in every direction."""
    shown, solid = (_sides((Pose(), one) for one in shapes) for shapes in (link.visuals, link.collisions))
    if shown is None or solid is None or min(shown.min(), solid.min()) < THINNEST_M:
        return
    ratios = max(shown / solid, solid / shown, key=np.max)
    if any(low < ratios.min() and ratios.max() < high for low, high in UNIT_RATIOS):
        yield (
            f"the visuals of the link '{link.name}' of '{model.name}' are {_listed(shown)} m, and its "
            f"collision shapes {_listed(solid)} m; is one of them in another unit?"
        )


def _distant_links(model: Model) -> Iterator[str]:
    """Yield the joints whose links are too far apart for their sizes."""
    largest_m = max(_sizes_m(map(shapes_of, model.links)), default=inf)
    places = {link.name: link.pose.position for link in model.links}
    for joint in model.joints:
        if WORLD in (joint.parent, joint.child) or not {joint.parent, joint.child} <= places.keys():
            continue
        away_m = dist(places[joint.parent], places[joint.child])
        if 0 < FAR_LINK * largest_m < away_m:
            yield (
                f"the joint '{joint.name}' of '{model.name}' connects links {away_m:.3g} m apart, and the "
                f"largest link is {largest_m:.2g} m; is a pose in mm?"
            )


def _distant_parts(model: Model) -> Iterator[str]:
    """Yield the first sensor, shape or centre of mass that is far from its link."""
    size_m = sum(_sizes_m([one] for link in model.links for one in shapes_of(link))) or inf
    for link in model.links:
        # a camera may watch its robot from afar
        parts = [
            (f"sensor '{one.name}'", getattr(one, "pose", None)) for one in link.sensors if not one.views
        ]
        parts += [(f"shape '{one.name}'", one.pose) for one in shapes_of(link)]
        parts += [("centre of mass", link.inertial.pose)] if link.inertial is not None else []
        for part, pose in parts:
            away_m = hypot(*pose.position) if isinstance(pose, Pose) else 0.0
            if away_m > FAR_PART * size_m:
                yield (
                    f"the {part} of the link '{link.name}' of '{model.name}' is {away_m:.3g} m from the "
                    f"link, and all shapes together measure {size_m:.3g} m; is its pose in mm?"
                )
                return


def _low_density(model: Model) -> Iterator[str]:
    sides = _sides((link.pose, one) for link in model.links for one in shapes_of(link))
    mass = sum(link.inertial.mass for link in model.links if link.inertial is not None)
    if sides is not None and 0 < mass < LEAST_DENSITY * sides.prod():
        yield (
            f"'{model.name}' weighs {mass:.3g} kg in a box of {_listed(sides)} m around it: "
            f"{mass / sides.prod():.2g} kg/m^3, less than air; are its lengths in mm?"
        )


def _sides(shapes: Iterable[tuple[Pose, Collision | Visual]]) -> FloatArray | None:
    """Return the sides of the box around shapes in their frames, m; None without a bounded one."""
    box = box_around((frame @ one.pose, one.geometry) for frame, one in shapes)
    return None if box is None else box[1] - box[0]


def _sizes_m(parts: Iterable[Sequence[Collision | Visual]]) -> list[float]:
    """Return the diagonal of each part of a link that has bounded shapes, m."""
    sides = (_sides((Pose(), one) for one in shapes) for shapes in parts)
    return [float(np.linalg.norm(one)) for one in sides if one is not None]


def _listed(sides: FloatArray) -> str:
    return " x ".join(f"{one:.2g}" for one in sides)


@checks_experiment
def check_physics_step(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Check the step of the physics engine against that of the loop."""
    if examined.world is None or not examined.world.capabilities.step_ns:
        return
    experiment, capabilities = examined.experiment, examined.world.capabilities
    keys, step_ns = place_of_step(experiment), capabilities.step_ns
    step = f"{milliseconds(step_ns):g} ms"
    message = ""
    if experiment.timestep > MAX_STEPS * step_ns:
        count = experiment.timestep // step_ns
        message = f"the world takes {count} steps of {step} in each step of the loop; is its unit wrong?"
    elif examined.bodies_fall and keys[0] == "world" and step_ns > LONGEST_STEP_NS:
        message = (
            f"the physics step is {step}, and 1 to 5 ms are usual: contacts and controllers act late; is the "
            "step of the loop meant?"
        )
    if message:
        yield examined.warning(Code.NRP372, message, *keys)
