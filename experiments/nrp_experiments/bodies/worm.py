"""The nematode *C. elegans* as SDF: rods on a line, joined by hinges, in a medium with linear drag.

The body is that of J. H. Boyle, S. Berri and N. Cohen, Gait modulation in C. elegans: an integrated
neuromechanical model, Front. Comput. Neurosci. 6:10 (2012), table 1, with one simplification: rods are
hinged at a fixed distance, where theirs are held by stiff diagonal springs. Between two rods, an elastic wall
and a muscle run along each side; a bend of the angle ``q`` changes their lengths by plus and minus
``radius * q``. The walls are springs and dampers of the hinges; :meth:`Worm.torques` are the muscles.

No physics engine simulates a worm of a millimetre: its inertia is 1e-20 kg m^2. This one is a thousand times
as long. Times stay, forces are 1e6 and torques 1e9 times as large, coefficients of drag 1e3 times, so that
positions, a thousand times as large, are the same functions of time. Inertia plays no part in the original,
which has none: here each rod comes to rest within 2 ms, by the drag across it.

    python -m nrp_experiments.bodies.worm agar > worm_on_agar.sdf
    python -m nrp_experiments.bodies.worm water > worm_in_water.sdf
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import Any, ClassVar

import numpy as np

from nrp_experiments.bodies.elements import material, number

Array = np.ndarray[Any, np.dtype[np.float64]]

MEDIA = {"agar": (3.2, 128.0), "water": (3.3e-3, 5.2e-3)}
"""Drag of the worm along and across its body, N s/m, of which half acts on the rods, as in their program."""
SETTLING_S = 2e-3
TURNING = {"agar": 2e-5, "water": 5e-8}
"""Inertia of a rod, kg m^2: so small that it has no effect on the gait."""
SKIN, HEAD = "0.86 0.76 0.58", "0.62 0.36 0.24"


@dataclass(frozen=True)
class Worm:
    """The dimensions and walls of the worm.

    Args:
        segments: the number of hinges; there is one rod more.
        length: of the body, m.
        thick: the largest diameter, m.
        activation: the activation for which the damper of a hinge is right; :meth:`torques` adds the rest.

    Attributes:
        shrinking: by how much a muscle of full activation shortens, as a share of its length where the body
            is thickest.
    """

    segments: int = 24
    length: float = 1.0
    thick: float = 0.08
    activation: float = 0.35

    shrinking: ClassVar[float] = 0.65
    wall: ClassVar[float] = 10.0 / 24
    """Stiffness of a wall with one segment, N/m; 25 ms is the time constant of its damper."""

    @cached_property
    def rod_radius(self) -> Array:
        """Half the length of each rod, shape ``(segments + 1,)``, m: an ellipse."""
        half = self.segments / 2
        radii: Array = (
            self.thick / 2 * np.sin(np.arccos((np.arange(self.segments + 1) - half) / (half + 0.2)))
        )
        return radii

    @cached_property
    def radius(self) -> Array:
        """The distance of the walls from each hinge, shape ``(segments,)``, m."""
        return (self.rod_radius[1:] + self.rod_radius[:-1]) / 2

    @cached_property
    def rest(self) -> Array:
        """The length of the walls at rest, shape ``(segments,)``, m."""
        return np.hypot(self.length / self.segments, np.diff(self.rod_radius))

    @cached_property
    def stiffness(self) -> Array:
        """The stiffness of each hinge by its walls, N m/rad."""
        return 2 * self.segments * self.wall * self.radius**2

    @property
    def damping(self) -> Array:
        """The damping of each hinge by its walls and by muscles of :attr:`activation`, N m s/rad."""
        return 0.025 * (1 + 50 * self.activation) * self.stiffness

    def stretch(self, angles: Array) -> tuple[Array, Array]:
        """Return by which share dorsal and ventral walls are stretched, as if the body were a cylinder."""
        strain = self.thick / 2 * angles / self.rest
        return np.where(
            self.rest + self.radius * angles > self.length / self.segments, 0.8, 1.2
        ) * strain, -strain

    def torques(self, dorsal: Array, ventral: Array, angles: Array, speeds: Array) -> Array:
        """Return the torques of the muscles on the hinges.

        A muscle of activation ``a`` is a spring of ``20 a`` times the stiffness of the wall, with a length at
        rest that is shorter by ``a`` times ``shrinking``, and a damper.

        Args:
            dorsal, ventral: activations, not negative, shape ``(segments,)``.
            angles, speeds: of the hinges, rad and rad/s; positive ones stretch the dorsal side.

        Returns:
            N m, shape ``(segments,)``; without the damping that the hinges have.
        """
        both = dorsal + ventral
        shorter = self.shrinking * self.radius / (self.thick / 2) * self.rest
        pull = (dorsal**2 - ventral**2) * shorter / self.radius + both * angles
        return -10 * self.stiffness * (pull + 0.125 * (both - self.activation) * speeds)


def sdf(worm: Worm, medium: str) -> str:
    """Return the worm in a medium as a file; the head is at the origin and the body behind it."""
    along, across = (drag / 2 for drag in MEDIA[medium])
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            "<!-- Made by nrp_experiments.bodies.worm, which describes it. -->",
            '<sdf version="1.9">',
            '  <model name="worm">',
            *_rods(worm, SETTLING_S * across / (worm.segments + 1), TURNING[medium]),
            *_hinges(worm),
            *_drag(worm, along, across),
            "  </model>",
            "</sdf>",
            "",
        ]
    )


def _rods(worm: Worm, mass: float, turning: float) -> Iterator[str]:
    size = worm.length / worm.segments
    moments = "".join(f"<i{axis}{axis}>{number(turning)}</i{axis}{axis}>" for axis in "xyz")
    for index, radius in enumerate(worm.rod_radius):
        capsule = f"<capsule><radius>{number(radius)}</radius><length>{number(size)}</length></capsule>"
        yield f'    <link name="rod_{index}">'
        yield f"      <pose>{number(-size * index)} 0 0 0 0 0</pose>"
        yield f"      <inertial><mass>{number(mass)}</mass><inertia>{moments}</inertia></inertial>"
        yield (
            f'      <visual name="skin"><pose>0 0 0 0 {number(pi / 2)} 0</pose><geometry>{capsule}</geometry>'
            f"{material(SKIN if index else HEAD)}</visual>"
        )
        yield "    </link>"


def _hinges(worm: Worm) -> Iterator[str]:
    for index, (stiffness, damping) in enumerate(zip(worm.stiffness, worm.damping, strict=True)):
        yield f'    <joint name="hinge_{index}" type="revolute">'
        yield f"      <pose>{number(worm.length / worm.segments / 2)} 0 0 0 0 0</pose>"
        yield f"      <parent>rod_{index}</parent><child>rod_{index + 1}</child>"
        yield "      <axis><xyz>0 0 1</xyz><limit><lower>-1.5</lower><upper>1.5</upper></limit>"
        yield (
            f"        <dynamics><damping>{number(damping)}</damping><spring_reference>0</spring_reference>"
            f"<spring_stiffness>{number(stiffness)}</spring_stiffness></dynamics></axis>"
        )
        yield "    </joint>"


def _drag(worm: Worm, along: float, across: float) -> Iterator[str]:
    yield '    <plugin name="drag" filename="nrp_drag">'
    yield f"      <along>{number(along / worm.length)}</along><across>{number(across / worm.length)}</across>"
    size = worm.length / (worm.segments + 1)
    for index in range(worm.segments + 1):
        yield f'      <link length="{number(size)}">rod_{index}</link>'
    yield "    </plugin>"


if __name__ == "__main__":
    print(sdf(Worm(), sys.argv[1]), end="")
