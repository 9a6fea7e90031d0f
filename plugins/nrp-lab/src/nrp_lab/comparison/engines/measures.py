"""The measures between two engines with the same inputs, and their margins."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_lab.comparison.engines.differences import MISSING, SignalDifference, difference
from nrp_lab.comparison.engines.signals import Kind, signals_of
from nrp_lab.comparison.metrics.base import GivenMargins, Margin
from nrp_lab.comparison.signals import RunSignals

_NEAR_S = 0.01
"""Spikes of a neuron in two runs that are closer than this correspond to each other, s."""
_FEWEST_SPIKES = 5


@dataclass(frozen=True, slots=True)
class Measure:
    """A quantity in which engines may differ.

    Args:
        name: name on the command line.
        title: name in a report.
        unit: unit of the difference and of its margin.
        margin: the largest difference that a user of the robot does not notice.
        reason: the reason for this margin, as a sentence.
    """

    name: str
    title: str
    unit: str
    margin: float
    reason: str


MOTION = Measure(
    "motion", "motion", "%", 1.0, "After a metre the robot is off by a centimetre, as real robots are."
)
MOTION_DELAY = Measure(
    "motion_delay",
    "delay of motion",
    "ms",
    10.0,
    "It is half of the usual step, the shortest time in a loop.",
)
SENSOR = Measure(
    "sensor",
    "sensor values",
    "%",
    3.0,
    "Sensors of mobile robots are specified to a few percent of their value.",
)
SENSOR_DELAY = Measure(
    "sensor_delay",
    "delay of sensors",
    "ms",
    10.0,
    "It is half of the usual step: sensor data acts one step later.",
)
SENSOR_NOISE = Measure(
    "sensor_noise",
    "noise of sensors",
    "%",
    2.0,
    "Scanners and depth cameras are specified with noise of 1 to 2 % of the distance.",
)
CAMERA = Measure(
    "camera",
    "images",
    "%",
    2.0,
    "Share of full brightness: not visible, and within the tolerance of colour detectors.",
)
INPUT = Measure(
    "input",
    "input of the brain",
    "%",
    5.0,
    "A Poisson source of 100 Hz varies by more than that between periods of ten seconds.",
)
FIRING = Measure(
    "firing",
    "firing rate",
    "%",
    3.0,
    "A wheel that follows it turns 3 % faster; cells vary more from trial to trial.",
)
SPIKE_TIME = Measure(
    "spike_time",
    "spike times",
    "ms",
    4.0,
    "It is a fifth of the usual step, in which a brain acts once on its body.",
)
OUTPUT = Measure(
    "output",
    "output of the brain",
    "%",
    2.0,
    "It drives the robot, whose wheels and motors differ by as much.",
)
MEASURES = (
    MOTION, MOTION_DELAY, SENSOR, SENSOR_DELAY, SENSOR_NOISE, CAMERA, INPUT, FIRING, SPIKE_TIME, OUTPUT,
)  # fmt: skip

_LEVELS = {
    Kind.MOTION: MOTION, Kind.SENSOR: SENSOR, Kind.CAMERA: CAMERA, Kind.INPUT: INPUT, Kind.OUTPUT: OUTPUT
}  # fmt: skip
_DELAYS = {Kind.MOTION: MOTION_DELAY, Kind.SENSOR: SENSOR_DELAY, Kind.CAMERA: SENSOR_DELAY}
_NOISES = {Kind.SENSOR: SENSOR_NOISE, Kind.CAMERA: SENSOR_NOISE}
WORLD = frozenset({Kind.MOTION, Kind.SENSOR, Kind.CAMERA, Kind.INPUT})
"""Outputs of a world; the inputs of the brain follow from them."""
BRAIN = frozenset({Kind.OUTPUT})
"""Outputs of a brain besides its spikes."""


@dataclass(frozen=True, slots=True)
class Apart:
    """The difference in one part of a measure, in the measure's unit."""

    measure: Measure
    part: str
    amount: float


def measured(one: RunSignals, other: RunSignals, kinds: Iterable[Kind], *, spikes: bool) -> list[Apart]:
    """Return the differences of two runs in all parts of all measures.

    Args:
        one: a run.
        other: another run over the same time.
        kinds: the kinds of signals to compare.
        spikes: whether to compare spikes.
    """
    ours, theirs = signals_of(one), signals_of(other)
    chosen = frozenset(kinds)
    found: list[Apart] = []
    for name in dict.fromkeys((*ours, *theirs)):
        kind = (ours.get(name) or theirs[name]).kind
        if kind in chosen:
            both = name in ours and name in theirs
            apart = difference(ours[name], theirs[name], one.step_s) if both else MISSING
            found += [] if apart is None else _rows(kind, name, apart)
    return [*found, *(_firing(one, other) if spikes else ())]


def _rows(kind: Kind, name: str, apart: SignalDifference) -> Iterator[Apart]:
    yield Apart(_LEVELS[kind], name, apart.level_percent)
    if kind in _DELAYS:
        yield Apart(_DELAYS[kind], name, 1e3 * apart.delay_s)
    if kind in _NOISES:
        yield Apart(_NOISES[kind], name, apart.noise_percent)


# -- spikes


def _firing(one: RunSignals, other: RunSignals) -> Iterator[Apart]:
    ours, theirs = dict(_trains(one)), dict(_trains(other))
    for part in dict.fromkeys((*ours, *theirs)):
        a, b = ours.get(part, []), theirs.get(part, [])
        yield Apart(FIRING, part, _more_percent(sum(map(len, a)), sum(map(len, b)), max(len(a), len(b))))
        late_s = _late_s(a, b)
        if late_s is not None:
            yield Apart(SPIKE_TIME, part, 1e3 * late_s)


def _trains(run: RunSignals) -> Iterator[tuple[str, list[FloatArray]]]:
    """Return the spikes of populations and named groups; single cells vary without effect on a robot."""
    for group in run.groups:
        yield group, run.trains_s(group)


def _more_percent(one: int, other: int, cells: int) -> float:
    """Return the difference in the number of spikes, %, beyond one for each cell at the ends of a run."""
    apart = max(abs(other - one) - cells, 0)
    return float(np.copysign(100 * apart / max(one, other, 1), other - one))


def _late_s(one: list[FloatArray], other: list[FloatArray]) -> float | None:
    """Return the mean delay of spikes, s; None if there are too few."""
    late = [shift for a, b in zip(one, other, strict=False) if len(a) and len(b) for shift in _shifts(a, b)]
    return float(np.mean(late)) if len(late) >= _FEWEST_SPIKES else None


def _shifts(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the time from each spike to the nearest one of the other train, s, if one is near."""
    after = (
        np.clip(np.searchsorted(other, one), 1, len(other) - 1) if len(other) > 1 else np.zeros(len(one), int)
    )
    candidates = np.stack([other[np.maximum(after - 1, 0)] - one, other[after] - one])
    nearest: FloatArray = candidates[np.abs(candidates).argmin(axis=0), np.arange(len(one))]
    return nearest[np.abs(nearest) < _NEAR_S]


# -- margins


class EngineMargins(GivenMargins[float]):
    """The margins that were set for measures; every measure has a default."""

    @classmethod
    def parse(cls, texts: Iterable[str]) -> EngineMargins:
        """Read ``measure=value`` and ``measure/part=value``; the value may have the measure's unit.

        Raises:
            ValueError: one is written differently, or is in standard deviations.
        """
        units = {measure.name: measure.unit for measure in MEASURES}
        found: dict[str, float] = {}
        for text in texts:
            key, _, value = text.rpartition("=")
            name = key.partition("/")[0]
            margin = Margin.parse(value, units[name])
            if margin.in_sd:
                raise ValueError(
                    f"'{name}' compares single runs: its margin is in {units[name]}, not '{value}'"
                )
            found[key] = margin.amount
        return cls(found)

    def of(self, measure: Measure, part: str) -> float:
        """Return the margin of a part."""
        return self.or_default(measure.name, part, measure.margin)


DEFAULT_MARGINS = EngineMargins()
"""The margins of the measures themselves."""


def is_measure(margin: str) -> bool:
    """Return whether ``NAME=VALUE`` or ``NAME/PART=VALUE`` sets the margin of a measure of engines."""
    return margin.rpartition("=")[0].partition("/")[0] in {measure.name for measure in MEASURES}
