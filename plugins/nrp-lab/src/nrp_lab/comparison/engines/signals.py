"""All outputs of an engine in a run, as arrays over the steps of the loop."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import seconds
from nrp_core.recording.images import values_of
from nrp_core.recording.layout import Role
from nrp_core.recording.reading.mcap_messages import RecordedTopic
from nrp_core.world.messages.geometry_msgs import Quaternion
from nrp_core.world.messages.sensor_msgs import CompressedImage, Image
from nrp_core.world.model_states import MODEL_STATES
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
    """Read sensors and cameras; arrays whose length changes are left out."""
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
