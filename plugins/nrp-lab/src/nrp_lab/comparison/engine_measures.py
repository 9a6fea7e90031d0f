"""Signals of two engines with the same inputs, the measures between them, and their margins."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from math import inf
from typing import Any

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.clock import seconds
from nrp_core.messages.geometry_msgs import Quaternion
from nrp_core.messages.sensor_msgs import CompressedImage, Image
from nrp_core.recording import RecordedTopic, Role, values_of
from nrp_core.world.model_states import MODEL_STATES
from nrp_lab.comparison.metric import Margin, Margins
from nrp_lab.comparison.signals import RunSignals

_BLOCKS = 6
"""An image is reduced to the means of this many blocks along each side."""
_FULL_SCALE = 255.0
_LEFT_OUT = ("header", "covariance", "angle_", "range_m", "time_", "scan_time")
"""Fields of messages that are not measured, by the beginning or the end of their names."""
_FLOORS = {
    "linear_acceleration": 1.0, "angular_velocity": 0.5, "linear": 0.1, "angular": 0.5, "ranges": 0.1,
    "position": 0.05, "velocity": 0.05, "effort": 0.1, "force": 1.0, "torque": 0.1,
}  # fmt: skip
"""Amplitudes in SI units below which a signal counts as constant: relative differences would be noise."""


class Kind(StrEnum):
    """The kind of a signal; measures choose by it."""

    MOTION = "motion"
    SENSOR = "sensor"
    CAMERA = "camera"
    INPUT = "input"
    OUTPUT = "output"


@dataclass(frozen=True, slots=True)
class Signal:
    """One signal over time.

    Args:
        kind: its kind.
        values: at the end of each step, NaN before the first message, shape ``(n_steps, n_values)``.
        floor: amplitude below which it counts as constant, in its own unit.
        full_scale: the reference of relative differences; None: its own amplitude.
    """

    kind: Kind
    values: FloatArray
    floor: float = 1e-6
    full_scale: float | None = None


def signals_of(run: RunSignals) -> dict[str, Signal]:
    """Return every signal of a run by its name."""
    return {**_motions(run), **_sensors(run), **_devices(run)}


# -- motion


def _motions(run: RunSignals) -> dict[str, Signal]:
    found: dict[str, Signal] = {}
    for series in run.numbers.with_role(Role.MODELS):
        poses = run.held(series)[:, :7]
        name = series.name.removeprefix(f"{MODEL_STATES}/")
        velocity, turning = _body_motion(poses, run.step_s)
        found[f"{name}/velocity"] = Signal(Kind.MOTION, velocity, _FLOORS["linear"])
        found[f"{name}/turn rate"] = Signal(Kind.MOTION, turning, _FLOORS["angular"])
    return found


def _body_motion(poses: FloatArray, step_s: float) -> tuple[FloatArray, FloatArray]:
    """Return the mean velocities over each step along the body's axes, m/s and rad/s, each ``(n, 3)``."""
    axes = _axes_of(poses[:, 3:])
    moved = np.diff(poses[:, :3], axis=0) / step_s
    turned = np.einsum("nji,njk->nik", axes[:-1], axes[1:])
    skew = (turned - turned.transpose(0, 2, 1)) / 2
    rates = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    sines = np.linalg.norm(rates, axis=1, keepdims=True)
    cosines = (np.trace(turned, axis1=1, axis2=2)[:, None] - 1) / 2
    scale = np.where(sines > 1e-9, np.arctan2(sines, cosines) / np.maximum(sines, 1e-9), 1.0)
    return np.einsum("nji,nj->ni", axes[:-1], moved), rates * scale / step_s


def _axes_of(quaternions: FloatArray) -> FloatArray:
    """Return rotation matrices, shape ``(n, 3, 3)``, of quaternions x, y, z, w: q and -q are the same."""
    x, y, z, w = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrices: FloatArray = np.array(rows).transpose(2, 0, 1)
    return matrices


# -- devices


def _devices(run: RunSignals) -> dict[str, Signal]:
    kinds = {Role.SINK: Kind.OUTPUT, Role.SOURCE: Kind.INPUT}
    return {
        series.name.removeprefix("/brain/devices/"): Signal(kind, run.held(series))
        for role, kind in kinds.items()
        for series in run.numbers.with_role(role)
    }


# -- sensors


def _sensors(run: RunSignals) -> dict[str, Signal]:
    """Read sensors and cameras, without arrays whose length changes."""
    topics = {one.name: one for one in run.recording.with_role(Role.SENSOR, Role.CAMERA)}
    times: dict[str, list[float]] = {}
    values: dict[str, list[FloatArray]] = {}
    for recorded in run.recording.messages(set(topics)):
        for name, numbers in _leaves(topics[recorded.topic], recorded.message):
            times.setdefault(name, []).append(seconds(recorded.t_ns))
            values.setdefault(name, []).append(numbers)
    found: dict[str, Signal] = {}
    for name, rows in values.items():
        if len({len(row) for row in rows}) == 1 and len(rows[0]):
            held = _held(run, np.array(times[name]), np.array(rows, float))
            found[name] = _sensed(name, held, is_image=name in topics)
    return found


def _sensed(name: str, values: FloatArray, *, is_image: bool) -> Signal:
    if is_image:
        return Signal(Kind.CAMERA, values, full_scale=_FULL_SCALE)
    return Signal(Kind.SENSOR, values, _FLOORS.get(name.rpartition(".")[2], 1e-6))


def _held(run: RunSignals, times_s: FloatArray, values: FloatArray) -> FloatArray:
    index = np.searchsorted(times_s, run.times_s + run.step_s * 1e-3, side="right") - 1
    return np.where(index[:, None] >= 0, values[np.maximum(index, 0)], np.nan)


def _leaves(topic: RecordedTopic, message: Any) -> Iterator[tuple[str, FloatArray]]:
    if isinstance(message, Image | CompressedImage):
        pixels = values_of(message)
        if pixels.dtype == np.uint8:
            yield topic.name, _blocks(pixels)
        return
    yield from _numbers(message, topic.name)


def _numbers(value: Any, name: str) -> Iterator[tuple[str, FloatArray]]:
    """Return the vectors and arrays in a message."""
    if isinstance(value, Quaternion):
        yield name, _axes_of(np.array([[value.x, value.y, value.z, value.w]]))[0].ravel()
        return
    fields = {spec.name: getattr(value, spec.name) for spec in dataclasses.fields(value)}
    if all(isinstance(one, float) for one in fields.values()) and len(fields) > 1:
        yield name, np.array(list(fields.values()))
        return
    for field, inner in fields.items():
        if field.startswith(_LEFT_OUT) or field.endswith("covariance"):
            continue
        if dataclasses.is_dataclass(inner):
            yield from _numbers(inner, f"{name}.{field}")
        elif isinstance(inner, bool | int | float):
            yield f"{name}.{field}", np.array([float(inner)])
        elif _is_numeric(inner):
            yield f"{name}.{field}", np.asarray(inner, float).ravel()


def _is_numeric(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "fi"  # unsigned integers are bytes of other data
    return isinstance(value, list) and bool(value) and all(isinstance(one, int | float) for one in value)


def _blocks(pixels: Any) -> FloatArray:
    """Return the mean of each block of an image and colour."""
    values = np.asarray(pixels, float).reshape(*pixels.shape[:2], -1)
    rows = np.array_split(values, min(_BLOCKS, len(values)), axis=0)
    columns = min(_BLOCKS, values.shape[1])
    parts = [one.mean(axis=(0, 1)) for row in rows for one in np.array_split(row, columns, axis=1)]
    blocks: FloatArray = np.concatenate(parts)
    return blocks


_WINDOW = 11
"""Steps of the moving mean that separates a signal into its level and its noise."""
_LAGS = 10
"""Maximum delay that is searched for, steps."""
_EXPLAINS = 0.2
"""A delay is accepted if the remaining difference is less than this share of the difference without it."""
_SILENT = 1e-3
"""Differences below this share of a signal are not searched for a delay."""


@dataclass(frozen=True, slots=True)
class SignalDifference:
    """The difference between a signal in two runs.

    Args:
        level_percent: mean difference of the smoothed signals without the delay, % of the amplitude.
        delay_s: delay of the other signal, s.
        noise_percent: root of the difference of the mean squares that smoothing removes, % of the
            amplitude.
    """

    level_percent: float
    delay_s: float
    noise_percent: float


MISSING = SignalDifference(inf, 0.0, 0.0)


def difference(one: Signal, other: Signal, step_s: float) -> SignalDifference | None:
    """Return the difference of two signals; None if they have no step in common."""
    if one.values.shape[1] != other.values.shape[1]:
        return MISSING
    steps = min(len(one.values), len(other.values))
    a, b = (np.where(np.isfinite(s.values[:steps]), s.values[:steps], np.nan) for s in (one, other))
    apart_in_presence = np.isfinite(a).mean() - np.isfinite(b).mean()
    seen = np.isfinite(a) & np.isfinite(b)
    if not seen.any():
        return None if not (np.isfinite(a).any() or np.isfinite(b).any()) else MISSING
    a, b = np.where(seen, a, 0.0), np.where(seen, b, 0.0)
    amplitude = max(float(_size(a).mean()), float(_size(b).mean()), one.floor)
    scale = one.full_scale or amplitude
    lag = _lag(a, b, scale)
    a, b = _shifted(a, b, lag)
    low_a, low_b = _smooth(a), _smooth(b)
    level = float(_size(low_b - low_a).mean()) / scale + abs(float(apart_in_presence))
    noise = abs(_power(b - low_b) - _power(a - low_a)) ** 0.5  # the squares of independent noise add up
    return SignalDifference(100 * level, lag * step_s, 100 * noise / scale)


def _lag(a: FloatArray, b: FloatArray, scale: float) -> int:
    """Return the number of steps that explains most of the difference; 0 if none explains enough."""
    reach = min(_LAGS, len(a) // 4)
    now = float(_size(b - a).mean())
    if now < _SILENT * scale:
        return 0
    left = {lag: float(_size(np.subtract(*_shifted(b, a, -lag))).mean()) for lag in range(-reach, reach + 1)}
    best = min(left, key=lambda lag: (left[lag], abs(lag)))
    return best if left[best] < _EXPLAINS * now else 0


def _shifted(a: FloatArray, b: FloatArray, lag: int) -> tuple[FloatArray, FloatArray]:
    """Return both over the time they have in common if ``b`` is late by ``lag`` steps."""
    if lag == 0:
        return a, b
    return (a[:-lag], b[lag:]) if lag > 0 else (a[-lag:], b[:lag])


def _size(values: FloatArray) -> FloatArray:
    """Return the length of a vector, or the mean of an array, for each step."""
    if values.shape[1] <= 3:
        return np.asarray(np.linalg.norm(values, axis=1), float)
    return np.asarray(np.abs(values).mean(axis=1), float)


def _power(values: FloatArray) -> float:
    """Return the mean square of each number of an array; of a vector, of its length."""
    squares = (values**2).mean(axis=0)
    return float(squares.sum() if len(squares) <= 3 else squares.mean())


def _smooth(values: FloatArray) -> FloatArray:
    """Return the moving mean; shorter at both ends."""
    window = min(_WINDOW, len(values))
    weights = np.convolve(np.ones(len(values)), np.ones(window), "same")
    columns = [np.convolve(column, np.ones(window), "same") / weights for column in values.T]
    return np.array(columns).T


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
    """

    name: str
    title: str
    unit: str
    margin: Margin


def _measure(name: str, title: str, unit: str, margin: float) -> Measure:
    return Measure(name, title, unit, Margin(margin, in_sd=False))


MOTION = _measure("motion", "motion", "%", 1.0)  # after a metre off by a centimetre, as real robots are
MOTION_DELAY = _measure("motion_delay", "delay of motion", "ms", 10.0)  # half of the usual step
SENSOR = _measure("sensor", "sensor values", "%", 3.0)  # as sensors of mobile robots are specified
SENSOR_DELAY = _measure("sensor_delay", "delay of sensors", "ms", 10.0)  # sensor data acts one step later
SENSOR_NOISE = _measure("sensor_noise", "noise of sensors", "%", 2.0)  # of scanners: 1 to 2 % of a distance
CAMERA = _measure("camera", "images", "%", 2.0)  # of full brightness: not visible
INPUT = _measure("input", "input of the brain", "%", 5.0)  # a Poisson source of 100 Hz varies more in 10 s
FIRING = _measure("firing", "firing rate", "%", 3.0)  # cells vary more from trial to trial
SPIKE_TIME = _measure("spike_time", "spike times", "ms", 4.0)  # a fifth of the usual step
OUTPUT = _measure("output", "output of the brain", "%", 2.0)  # as wheels and motors differ
MEASURES = (
    MOTION, MOTION_DELAY, SENSOR, SENSOR_DELAY, SENSOR_NOISE, CAMERA, INPUT, FIRING, SPIKE_TIME, OUTPUT,
)  # fmt: skip

_LEVELS = {
    Kind.MOTION: MOTION, Kind.SENSOR: SENSOR, Kind.CAMERA: CAMERA, Kind.INPUT: INPUT, Kind.OUTPUT: OUTPUT
}  # fmt: skip
_DELAYS = {Kind.MOTION: MOTION_DELAY, Kind.SENSOR: SENSOR_DELAY, Kind.CAMERA: SENSOR_DELAY}
_NOISES = {Kind.SENSOR: SENSOR_NOISE, Kind.CAMERA: SENSOR_NOISE}
_KINDS = {
    "world": {Kind.MOTION, Kind.SENSOR, Kind.CAMERA, Kind.INPUT},  # the inputs of the brain follow from these
    "brain": {Kind.OUTPUT},  # besides its spikes
    "run": set(Kind),
}


Apart = tuple[Measure, str, float]
"""A measure, a part of it, and the difference in it, in the measure's unit."""


@dataclass(frozen=True, slots=True)
class EngineDifference:
    """One part of a measure between two engines that had the same inputs.

    Args:
        side: ``brain`` or ``world``; of two recordings ``run``.
        one, other: names of the engines.
        measure: the measure.
        part: the signal, robot or neurons.
        amount: the difference, other minus one where it has a sign, in the measure's unit.
        margin: the largest difference that does not matter, in the same unit.
        is_known: whether a baseline has it.
    """

    side: str
    one: str
    other: str
    measure: Measure
    part: str
    amount: float
    margin: float
    is_known: bool = False

    @property
    def size(self) -> float:
        """The difference in units of its margin."""
        return abs(self.amount) / self.margin

    @property
    def matters(self) -> bool:
        """Whether it is beyond its margin."""
        return self.size > 1

    @property
    def key(self) -> str:
        """Its name in a baseline."""
        return f"{self.side} {self.one} -> {self.other}: {self.measure.name}/{self.part}"

    @property
    def effect(self) -> str:
        """The difference as a text."""
        if abs(self.amount) == inf:
            return "only one of them has it"
        return f"{self.amount:.3g} {self.measure.unit}, {self.size:.2g} x its margin"


def differences(
    one: RunSignals, other: RunSignals, side: str, names: tuple[str, str], margins: Margins
) -> list[EngineDifference]:
    """Return the differences of two runs in all parts of the measures of a side.

    Args:
        one: a run.
        other: another run over the same time.
        side: ``brain``, ``world``, or ``run`` for both.
        names: the names of their engines.
        margins: the margins that were set.
    """
    kinds, ours, theirs = _KINDS[side], signals_of(one), signals_of(other)
    found: list[Apart] = []
    for name in dict.fromkeys((*ours, *theirs)):
        kind = (ours.get(name) or theirs[name]).kind
        if kind in kinds:
            both = name in ours and name in theirs
            apart = difference(ours[name], theirs[name], one.step_s) if both else MISSING
            found += [] if apart is None else _rows(kind, name, apart)
    if side != "world":
        found += _firing(one, other)
    return [
        EngineDifference(side, *names, measure, part, amount, margins.of(measure, part).amount)
        for measure, part, amount in found
    ]


def _rows(kind: Kind, name: str, apart: SignalDifference) -> Iterator[Apart]:
    yield _LEVELS[kind], name, apart.level_percent
    if kind in _DELAYS:
        yield _DELAYS[kind], name, 1e3 * apart.delay_s
    if kind in _NOISES:
        yield _NOISES[kind], name, apart.noise_percent


# -- spikes


def _firing(one: RunSignals, other: RunSignals) -> Iterator[Apart]:
    ours, theirs = dict(_trains(one)), dict(_trains(other))
    for part in dict.fromkeys((*ours, *theirs)):
        a, b = ours.get(part, []), theirs.get(part, [])
        yield FIRING, part, _more_percent(sum(map(len, a)), sum(map(len, b)), max(len(a), len(b)))
        late_s = _late_s(a, b)
        if late_s is not None:
            yield SPIKE_TIME, part, 1e3 * late_s


def _trains(run: RunSignals) -> Iterator[tuple[str, list[FloatArray]]]:
    """Return the spikes of populations and named groups; single cells vary without effect on a robot."""
    for group in run.groups:
        yield group, run.trains_s(group)


def _more_percent(one: int, other: int, cells: int) -> float:
    """Return the difference in the number of spikes, %, beyond one for each cell at the ends of a run."""
    apart = max(abs(other - one) - cells, 0)
    return float(np.copysign(100 * apart / max(one, other, 1), other - one))


def _late_s(one: list[FloatArray], other: list[FloatArray]) -> float | None:
    """Return the mean delay of spikes, s; None for too few spikes."""
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


def is_measure(margin: str) -> bool:
    """Return whether ``NAME=VALUE`` or ``NAME/PART=VALUE`` sets the margin of a measure of engines."""
    return margin.rpartition("=")[0].partition("/")[0] in {measure.name for measure in MEASURES}
