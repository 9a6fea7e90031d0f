"""Recorded data as objects of pandas, xarray and Neo."""

from __future__ import annotations

import dataclasses
import importlib
import mmap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count, product
from math import prod
from typing import Any

import lz4.frame  # type: ignore[import-untyped]
import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import seconds
from nrp_core.errors import CapabilityError
from nrp_core.messages.base import type_name
from nrp_core.recording.reading.mcap_messages import McapMessages, RecordedTopic
from nrp_core.recording.writing.encoding import FRAME_HEADER

_UNITS = {
    "geometry_msgs/msg/Point": {"x": "m", "y": "m", "z": "m"},
    "geometry_msgs/msg/Pose2D": {"x": "m", "y": "m", "theta": "rad"},
    "geometry_msgs/msg/Transform": {"translation": "m"},
    "geometry_msgs/msg/Twist": {"linear": "m/s", "angular": "rad/s"},
    "geometry_msgs/msg/Accel": {"linear": "m/s^2", "angular": "rad/s^2"},
    "nrp_msgs/msg/MuscleState": {"length": "m", "velocity": "m/s", "force": "N"},
    "nrp_msgs/msg/MuscleStates": {"length": "m", "velocity": "m/s", "force": "N"},
    "geometry_msgs/msg/Wrench": {"force": "N", "torque": "N m"},
    "sensor_msgs/msg/Imu": {"angular_velocity": "rad/s", "linear_acceleration": "m/s^2"},
    "sensor_msgs/msg/MagneticField": {"magnetic_field": "T"},
    "sensor_msgs/msg/FluidPressure": {"fluid_pressure": "Pa"},
    "sensor_msgs/msg/NavSatFix": {"latitude": "deg", "longitude": "deg", "altitude": "m"},
    "sensor_msgs/msg/LaserScan": {
        "angle_min": "rad", "angle_max": "rad", "angle_increment": "rad", "time_increment": "s",
        "scan_time": "s", "range_min": "m", "range_max": "m", "ranges": "m",
    },
    "sensor_msgs/msg/Range": {"field_of_view": "rad", "min_range": "m", "max_range": "m", "range": "m"},
}  # fmt: skip
"""Units of the fields of a type and of everything in them (REP 103 and the definitions of the types)."""
_NAMES = ("name", "joint_names")
"""Fields with the names of the items of the other arrays of a message."""


@dataclasses.dataclass(frozen=True, slots=True)
class Value:
    """A value in a message.

    Args:
        path: names of the fields, joined by dots; an item of an array has a number or a name.
        value: a number, a truth value or a text.
        unit: its unit by the type of the message, or the empty string.
    """

    path: str
    value: Any
    unit: str


def numbers_in(message: Any) -> Iterator[tuple[str, float]]:
    """Return every number in a message and its arrays with its dotted path, as :func:`values_in` names it.

    Headers, covariances, bytes, and lists of messages are left out.
    """
    for one in number_values(message):
        yield one.path, one.value


def number_values(message: Any, elements: Sequence[str] = ()) -> Iterator[Value]:
    """Return the numbers of :func:`numbers_in` with their units, as far as the type gives them.

    Args:
        message: the message.
        elements: names of the items of an array in a message that gives none.
    """
    for one in _values(message, "", "", elements, whole=False):
        if not isinstance(one.value, str):
            yield Value(one.path, float(one.value), one.unit)


def values_in(message: Any, elements: Sequence[str] = ()) -> Iterator[Value]:
    """Return the values in a message, its arrays and its lists of messages; headers are left out.

    Items of an array are named by the message's list ``name`` or ``joint_names`` if it has the same length,
    as for joints and models, or by the given names. Otherwise they are numbered; along the axes of a layout,
    with their labels.

    Args:
        message: the message.
        elements: names of the items of an array in a message that gives none.
    """
    return _values(message, "", "", elements, whole=True)


def _values(message: Any, path: str, unit: str, elements: Sequence[str], *, whole: bool) -> Iterator[Value]:
    units, skipped = _UNITS.get(type_name(type(message)), {}), ["header"]
    layout = getattr(getattr(message, "layout", None), "dim", None)
    if layout is not None:
        skipped.append("layout")
    for field in _NAMES:
        names: Any = getattr(message, field, None)
        if _is_sequence(names):
            elements = names
            skipped.append(field)
    for spec in dataclasses.fields(message):
        value, own = getattr(message, spec.name), unit or units.get(spec.name, "")
        if spec.name in skipped or not (whole or _is_numeric(spec.name, value)):
            continue
        items = [("", value)]
        if _is_sequence(value):
            flat = value.ravel().tolist() if isinstance(value, np.ndarray) else value
            keys = _keys(len(flat), elements, layout or ())
            items = [(f".{key}", item) for key, item in zip(keys, flat, strict=True)]
        for key, item in items:
            if dataclasses.is_dataclass(item):
                yield from _values(item, f"{path}{spec.name}{key}.", own, elements, whole=whole)
            elif isinstance(item, (bool, int, float, str)):
                yield Value(f"{path}{spec.name}{key}", item, own)


def _is_numeric(name: str, value: Any) -> bool:
    """Return whether a field is no covariance, bytes, or list of messages or texts."""
    if not _is_sequence(value) or name.endswith("covariance"):
        return not _is_sequence(value)
    if isinstance(value, np.ndarray):
        return bool(value.dtype != np.uint8)
    return isinstance(next(iter(value), None), (bool, int, float))


def _keys(count: int, names: Sequence[str], layout: Sequence[Any]) -> Iterable[str]:
    """Return the keys of the items of an array: names, or numbers along the axes of its layout."""
    if names and len(names) == count:
        return names
    if layout and prod(axis.size for axis in layout) == count:
        axes = [[f"{axis.label}{number}" for number in range(axis.size)] for axis in layout]
        return map(".".join, product(*axes))
    return map(str, range(count))


def _is_sequence(value: Any) -> bool:
    return isinstance(value, np.ndarray) or (
        isinstance(value, Sequence) and not isinstance(value, (str, bytes))
    )


_BLOCK = 1 << 20


def unread_chunk(messages: McapMessages) -> int | None:
    """Return the position of a complete chunk that was skipped in reading a file, or None.

    The content of each chunk is one frame, which contains its length.
    """
    with messages.path.open("rb") as file:
        if not file.seek(0, 2):
            return None
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return next((at for at in _outside(data, messages.chunks) if _is_whole(data, at)), None)


def _outside(data: mmap.mmap, chunks: list[tuple[int, int]]) -> Iterator[int]:
    """Return the positions of possible starts of frames outside the chunks, which are in order."""
    begin = 0
    for first, last in [*chunks, (len(data), len(data))]:
        at = data.find(FRAME_HEADER, begin, first)
        while at >= 0:
            yield at
            at = data.find(FRAME_HEADER, at + 1, first)
        begin = last


def _is_whole(data: mmap.mmap, at: int) -> bool:
    unpacking = lz4.frame.LZ4FrameDecompressor()
    try:
        while at < len(data) and not unpacking.eof:
            unpacking.decompress(data[at : at + _BLOCK])
            at += _BLOCK
    except (RuntimeError, EOFError):
        return False
    return bool(unpacking.eof)


TIME = "time_s"


def library(name: str) -> Any:
    """Return a package for the analysis of data.

    Raises:
        CapabilityError: it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        raise CapabilityError(
            f"this needs the package {error.name}: pip install 'nrp-core[analysis]'"
        ) from error


def frame_of(topic: RecordedTopic, messages: Iterable[tuple[int, Any]]) -> Any:
    """Return the messages of a topic with their times, ns, as a DataFrame.

    Raises:
        CapabilityError: pandas is not installed.
    """
    pandas = library("pandas")
    times_s: list[float] = []
    rows: list[dict[str, Any]] = []
    units: dict[str, str] = {}
    elements = topic.elements
    for t_ns, message in messages:
        row: dict[str, Any] = {}
        for one in values_in(message, elements):
            row[one.path] = one.value
            units.setdefault(one.path, one.unit or topic.about.get("unit", ""))
        times_s.append(seconds(t_ns))
        rows.append(row)
    table = pandas.DataFrame(rows, index=pandas.Index(times_s, dtype=float, name=TIME), columns=list(units))
    table.attrs = {"topic": topic.name, "type": topic.type_name, "units": units}
    return table


def _axis_name(number: int) -> str:
    return f"{TIME}_{number + 1}" if number else TIME


def dataset_of(frames: Mapping[str, Any], about: Mapping[str, Any]) -> Any:
    """Return the numbers of tables as an xarray Dataset, a variable for each column.

    Tables with the same times share a coordinate: ``time_s``, ``time_s_2`` and so on, in s.

    Args:
        frames: the table of each topic, by its name.
        about: the attributes of the dataset.

    Raises:
        CapabilityError: xarray is not installed.
    """
    xarray = library("xarray")
    times: list[FloatArray] = []
    columns: dict[str, Any] = {}
    for topic, frame in frames.items():
        numeric = frame.select_dtypes(["number", "bool"])
        own = frame.index.to_numpy()
        number = next((n for n, other in enumerate(times) if np.array_equal(own, other)), len(times))
        if number == len(times):
            times.append(own)
        dimension = _axis_name(number)
        for name in numeric.columns:
            about_it = {"units": frame.attrs["units"][name], "topic": topic}
            key = f"{topic}.{name}".lstrip("/").replace("/", ".")  # NetCDF does not allow slashes
            while key in columns:  # the fields of another topic
                key += "_"
            columns[key] = (dimension, numeric[name].to_numpy(), about_it)
    axes = {
        name: (name, own, {"units": "s"}) for name, own in zip(map(_axis_name, count()), times, strict=False)
    }
    return xarray.Dataset(columns, axes, dict(about))


def joined_frames(topic: str, frames: Mapping[str, Any]) -> Any:
    """Return the tables of the devices of a group as one, in which each value holds until the next one.

    Args:
        topic: the pattern of the topics.
        frames: the table of each device by its number.
    """
    pandas = library("pandas")
    columns, units = {}, {}
    for number in sorted(frames, key=int):
        frame = frames[number][~frames[number].index.duplicated(keep="last")]
        for name in frame.columns:
            column = number if len(frame.columns) == 1 else f"{number}.{name}"
            columns[column], units[column] = frame[name], frame.attrs["units"][name]
    table = pandas.concat(columns, axis=1, sort=True).ffill()
    table.index.name = TIME
    table.attrs = {"topic": topic, "type": next(iter(frames.values())).attrs["type"], "units": units}
    return table


def segment_of(
    name: str, sizes: Mapping[str, int], spikes: Mapping[str, tuple[IntArray, FloatArray]], end_ms: float
) -> Any:
    """Return spikes as a Neo Segment with a SpikeTrain for each neuron.

    Args:
        name: the name of the segment.
        sizes: the number of neurons of each population.
        spikes: ids in the population and times, ms, by population.
        end_ms: the end of the recording, ms.

    Raises:
        CapabilityError: Neo is not installed.
    """
    neo = library("neo")
    segment = neo.Segment(name=name)
    for label, size in sizes.items():
        ids, times_ms = spikes.get(label, (np.empty(0, np.int64), np.empty(0)))
        order = np.lexsort((times_ms, ids))
        cuts = np.searchsorted(ids[order], np.arange(1, size))
        for neuron, train_ms in enumerate(np.split(times_ms[order], cuts) if size else ()):
            stop_ms = max(end_ms, train_ms.max(initial=0.0))  # a spike may be at the end, except for rounding
            segment.spiketrains.append(
                neo.SpikeTrain(
                    train_ms, units="ms", t_stop=stop_ms, name=f"{label} {neuron}",
                    population=label, neuron=neuron,
                )
            )  # fmt: skip
    return segment


def events_of(times_s: Mapping[str, float | None]) -> Any:
    """Return the times of events, s, as a DataFrame in the order of time.

    Raises:
        CapabilityError: pandas is not installed.
    """
    pandas = library("pandas")
    index = pandas.Index(list(times_s), dtype="str", name="event")
    table = pandas.DataFrame({TIME: pandas.Series(list(times_s.values()), index=index, dtype=float)})
    table = table.sort_values(TIME, kind="stable")
    table.attrs = {"units": {TIME: "s"}}
    return table
