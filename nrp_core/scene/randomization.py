"""Domain randomisation as data: which properties of a scene are drawn, and from which distributions.

:mod:`nrp_core.world.domain_randomization` draws them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import exp, isfinite, log
from typing import Final, Literal

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import SceneError, did_you_mean

Operation = Literal["scale", "add", "range"]
Distribution = Literal["uniform", "log_uniform", "normal"]

OPERATIONS: Final[dict[str, tuple[Operation, ...]]] = {
    "mass": ("scale", "add", "range"),
    "friction": ("scale", "add", "range"),
    "gains": ("scale",),
    "light": ("scale",),
    "sensor_position": ("add",),
    "sensor_orientation": ("add",),
    "sensor_noise": ("scale", "add", "range"),
    "sensor_bias": ("scale", "add", "range"),
}
"""The quantities that can be drawn, in the order in which they are, and the operations of each."""
UNITS: Final = {"mass": "kg", "sensor_position": "m", "sensor_orientation": "rad"}
"""The units of drawn numbers; others are factors, or in the unit of the sensor."""
_DEVIATIONS: Final = 4.0
"""The width of a range in standard deviations of its normal distribution."""


@dataclass(frozen=True, slots=True)
class Randomization:
    """A property of some parts of a scene that is drawn anew for each seed.

    Args:
        quantity: the property, a key of :data:`OPERATIONS`.
        pattern: a regular expression that matches whole names of parts: ``model/link`` for masses and
            friction, ``model/joint`` for gains, ``model/link/sensor`` for sensors, a name for lights.
        operation: ``scale`` multiplies the value of the scene, ``add`` adds to it, ``range`` replaces it.
        low, high: the least and the greatest number that is drawn, in SI units.
        distribution: ``uniform``; ``log_uniform``, whose logarithm is uniform; or ``normal`` with the mean in
            the middle and a quarter of the width as standard deviation, cut off at both ends.
        shared: whether all these parts get the same number; else each gets its own.

    Raises:
        SceneError: the quantity does not exist, it has no such operation, or the numbers are not a range.
    """

    quantity: str
    pattern: str
    operation: Operation
    low: float
    high: float
    distribution: Distribution = "uniform"
    shared: bool = False

    def __post_init__(self) -> None:
        if self.quantity not in OPERATIONS:
            hint = did_you_mean(self.quantity, OPERATIONS)
            raise SceneError(f"there is no quantity '{self.quantity}' to randomize{hint}")
        valid = OPERATIONS[self.quantity]
        if self.operation not in valid:
            names = " or ".join(f"'{name}'" for name in valid)
            raise SceneError(f"'{self.quantity}' is randomized by {names}, not by '{self.operation}'")
        if not (isfinite(self.low) and isfinite(self.high) and self.low < self.high):
            raise SceneError(f"{self.low:g} to {self.high:g} is not a range from a lower to a higher number")
        if self.distribution == "log_uniform" and self.low <= 0:
            raise SceneError(f"'log_uniform' needs numbers above 0, and the range begins at {self.low:g}")
        try:
            re.compile(self.pattern)
        except re.error as error:
            message = f"'{self.pattern}' is not a regular expression for names of parts: {error}"
            raise SceneError(message) from None

    def matches(self, part: str) -> bool:
        """Return whether a part is drawn."""
        return re.fullmatch(self.pattern, part) is not None

    def applied(self, nominal: float, drawn: float) -> float:
        """Return the value of a part, given that in the scene and the drawn number."""
        if self.operation == "range":
            return drawn
        return nominal * drawn if self.operation == "scale" else nominal + drawn

    def sample(self, random: np.random.Generator, count: int) -> FloatArray:
        """Return independent numbers, shape ``(count,)``."""
        low, high = self.low, self.high
        if self.distribution == "log_uniform":
            logs: FloatArray = random.uniform(log(low), log(high), count)
            return np.clip([exp(one) for one in logs], low, high)
        if self.distribution == "uniform":
            return random.uniform(low, high, count)
        drawn = np.full(count, np.nan)
        while (outside := ~((drawn >= low) & (drawn <= high))).any():
            drawn[outside] = random.normal((low + high) / 2, (high - low) / _DEVIATIONS, outside.sum())
        return drawn


@dataclass(frozen=True, slots=True)
class Draw:
    """What was drawn for a part.

    Args:
        quantity, operation: as of its :class:`Randomization`.
        part: the full name of the part.
        values: the numbers in SI units: one; for a sensor's pose one along or about each of its axes x, y, z;
            for gains those of p, i and d.
    """

    quantity: str
    part: str
    operation: Operation
    values: tuple[float, ...]

    def __str__(self) -> str:
        """Return it in one line: ``mass of husky/base_link: scale 0.94``."""
        numbers = ", ".join(f"{value:.6g}" for value in self.values)
        unit = f" {UNITS[self.quantity]}" if self.quantity in UNITS and self.operation != "scale" else ""
        return f"{self.quantity} of {self.part}: {self.operation} {numbers}{unit}"
