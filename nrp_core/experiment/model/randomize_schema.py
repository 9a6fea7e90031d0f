"""Domain randomisation in the form of the experiment file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, PlainValidator, WithJsonSchema

from nrp_core.errors import SceneError
from nrp_core.experiment.model.section import Range, Section
from nrp_core.scene.randomization import OPERATIONS, UNITS, Operation, Randomization
from nrp_core.units import factor

DrawnRange = Annotated[
    Range, PlainValidator(Range.parse), WithJsonSchema({"type": "string", "examples": ["0.8..1.2"]})
]
_OPERATIONS: tuple[Operation, ...] = ("scale", "add", "range")


class DrawnSection(Section):
    """How a property of the parts that a pattern matches is drawn."""

    alternatives = _OPERATIONS

    scale: DrawnRange | None = None
    """Multiply the value of the file by a number in this range: ``0.9..1.1``."""
    add: DrawnRange | None = None
    """Add a number in this range: ``-5..5 mm``."""
    range: DrawnRange | None = None
    """Replace it by a number in this range: ``0.4..1``."""
    distribution: Literal["uniform", "log_uniform", "normal"] = "uniform"
    """``normal`` has its mean in the middle, and a quarter of the width as standard deviation."""
    shared: bool = False
    """Whether all parts that the pattern matches get the same number."""

    def of(self, quantity: str, pattern: str) -> Randomization:
        """Return the same for a scene.

        Raises:
            SceneError: the quantity has no such operation, the numbers are not valid for it, or their unit
                is that of another one.
        """
        operation = next(name for name in _OPERATIONS if getattr(self, name) is not None)
        given: Range = getattr(self, operation)
        size = _size(given.unit, "" if operation == "scale" else UNITS.get(quantity, ""))
        return Randomization(
            quantity, pattern, operation, given.low * size, given.high * size, self.distribution, self.shared
        )


def _size(unit: str, base: str) -> float:
    """Return the size of the unit of a range in that of its quantity; empty for a number without one."""
    if unit and not base:
        raise SceneError(f"the numbers are without a unit, not in '{unit}'")
    try:
        return float(factor(unit, base)) if unit else 1.0
    except ValueError as error:
        raise SceneError(f"the numbers are in {base}: {error}") from None


Patterns: TypeAlias = dict[str, DrawnSection]


class RandomizeSection(Section):
    """What is drawn anew for each seed, by regular expressions for whole names of parts."""

    mass: Patterns = Field(default_factory=dict)
    """Masses of links, ``MODEL/LINK``, kg; moments of inertia in proportion."""
    friction: Patterns = Field(default_factory=dict)
    """Coefficients of friction of links, ``MODEL/LINK``."""
    gains: Patterns = Field(default_factory=dict)
    """Gains of the controllers of joints, ``MODEL/JOINT``, by ``scale``; p, i and d have a factor each."""
    light: Patterns = Field(default_factory=dict)
    """Brightness of lights, by ``scale``."""
    sensor_position: Patterns = Field(default_factory=dict)
    """Positions of sensors, ``MODEL/LINK/SENSOR``, along each of their axes, m, by ``add``."""
    sensor_orientation: Patterns = Field(default_factory=dict)
    """Orientations of sensors: roll, pitch and yaw in their own frame, rad, by ``add``."""
    sensor_noise: Patterns = Field(default_factory=dict)
    """Standard deviations of the noise of sensors, in their own unit."""
    sensor_bias: Patterns = Field(default_factory=dict)
    """Means of that noise."""

    def entries(self) -> Iterator[tuple[str, str, DrawnSection]]:
        """Yield quantity, pattern and range."""
        for quantity in OPERATIONS:
            for pattern, section in getattr(self, quantity).items():
                yield quantity, pattern, section
