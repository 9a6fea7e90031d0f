"""A recording in Neurodata Without Borders 2 (Rübel et al. 2022, eLife 11:e78362)."""

from __future__ import annotations

import json
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from pynwb import NWBHDF5IO, H5DataIO, NWBFile, TimeSeries
from pynwb.behavior import Position, SpatialSeries
from pynwb.file import Subject
from pynwb.image import ImageSeries
from pynwb.misc import Units

from nrp_core.brain import FloatArray
from nrp_core.clock import seconds
from nrp_core.recording import Numbers, Recording, Role, Series, groups_of, values_of
from nrp_core.utilities import new_file

_FRAME = "the world's: x, y and z in m, z up"
_UNKNOWN = "n/a"
_SPECIES = "http://purl.obolibrary.org/obo/NCBITaxon_32644"
"""NCBI's taxon for what has no species; DANDI demands one."""
_STEPS = "/nrp/steps"
"""The topic with the hash of every step of a run."""
_TOLERANCE_S = 1e-9
"""Times of messages are whole nanoseconds."""


def write_nwb(recording: Recording, path: Path) -> list[Path]:
    """Write one file and return it."""
    numbers = Numbers.of(recording)
    file = _file(recording, numbers)
    _add_units(file, numbers)
    for series in numbers.with_role(Role.VOLTAGE, Role.SINK, Role.SENSOR):
        file.add_acquisition(_series(series))
    for series in numbers.with_role(Role.SOURCE):
        file.add_stimulus(_series(series))
    commands = numbers.with_role(Role.PUBLISHED)
    if commands:
        module = file.create_processing_module("commands", "messages published to the robot and the room")
        for series in commands:
            module.add(_series(series))
    _add_motion(file, numbers.with_role(Role.MODELS))
    for topic in recording.with_role(Role.CAMERA):
        _add_images(file, recording, topic.name)
    with new_file(path) as root, NWBHDF5IO(file=root, mode="w") as writer:
        writer.write(file)
    return [path]


def _file(recording: Recording, numbers: Numbers) -> Any:
    run = numbers.run
    begun = str(run.get("recorded") or datetime.fromtimestamp(0, UTC).isoformat())
    settings = dict(run.get("settings") or {})
    kept = {key: run.get(key) for key in ("seed", "brain", "world", "machine", "result") if key in run}
    return NWBFile(
        session_description=str(run.get("experiment") or "a recording of nrp-core"),
        experiment_description=str(settings.get("description") or "") or None,
        identifier=_last_hash(recording),
        session_start_time=datetime.fromisoformat(begun),
        notes=json.dumps(kept),
        subject=Subject(
            subject_id=str(run.get("experiment") or "simulation"),
            species=_SPECIES,
            sex="U",
            age="P0D",
            description="a simulated network of spiking neurons and a simulated body",
        ),
        was_generated_by=[["nrp-core", version("nrp-core")]],
    )


def _last_hash(recording: Recording) -> str:
    """Return the end of the chain of hashes, which identifies the run."""
    last = ""
    for one in recording.messages({_STEPS}):
        last = one.message.chain
    return last or recording.file.name


def _add_units(file: Any, numbers: Numbers) -> None:
    """Write every neuron with its spikes, including silent ones."""
    groups = groups_of(numbers.run)
    neurons = [(label, i) for label in numbers.spikes for i in range(numbers.size_of(label))]
    if not neurons:
        return
    capabilities = dict(dict(numbers.run.get("brain") or {}).get("capabilities") or {})
    file.units = Units(
        name="units", description="the neurons of the network",
        resolution=seconds(capabilities.get("resolution_ns") or 1),
    )  # fmt: skip
    file.add_unit_column("population", "the population that the neuron belongs to")
    file.add_unit_column("neuron", "its place in the population, from 0")
    file.add_unit_column("groups", "names of the groups that it belongs to, separated by spaces")
    members = {name: {label: set(ids) for label, ids in parts.items()} for name, parts in groups.items()}
    trains = {label: _trains(*numbers.spikes[label], numbers.size_of(label)) for label in numbers.spikes}
    for label, neuron in neurons:
        own = [name for name, parts in members.items() if neuron in parts.get(label, ())]
        file.add_unit(
            spike_times=trains[label][neuron], obs_intervals=[[numbers.begin_s, numbers.end_s]],
            population=label, neuron=neuron, groups=" ".join(own),
        )  # fmt: skip


def _trains(ids: Any, times_ms: Any, size: int) -> list[Any]:
    """Return the spike times in s of each neuron."""
    order = np.lexsort((times_ms, ids))
    cuts = np.searchsorted(ids[order], np.arange(1, size))
    return np.split(times_ms[order] * 1e-3, cuts)


def _object_name(topic: str) -> str:
    """Return the name of an object in a file, where ``/`` separates groups."""
    return topic.strip("/").replace("/", ".")


def _series(series: Series) -> Any:
    values = series.values
    columns = ", ".join(series.columns)
    return TimeSeries(
        name=_object_name(series.name),
        data=values[:, 0] if values.shape[1] == 1 else values,
        unit=series.unit or _UNKNOWN,
        description=f"{series.about.get('device', series.name)}: {columns}",
        continuity="step",
        **_times(series.times_s),
    )


def _times(times_s: FloatArray) -> dict[str, Any]:
    """Return times of a series in NWB's form: a start and a rate if they are regular."""
    intervals = np.diff(times_s)
    if not len(intervals) or np.ptp(intervals) > _TOLERANCE_S:
        return {"timestamps": times_s}
    rate_hz = len(intervals) / float(times_s[-1] - times_s[0])
    return {"starting_time": float(times_s[0]), "rate": round(rate_hz, 6)}


def _add_motion(file: Any, models: list[Series]) -> None:
    if not models:
        return
    module = file.create_processing_module("behavior", "positions and orientations of everything that moves")
    places = Position(name="Position")
    for series in models:
        name = series.name.rsplit("/", 1)[-1]
        values, times = series.values, series.times_s
        places.add_spatial_series(
            SpatialSeries(
                name=name,
                data=values[:, :3],
                reference_frame=_FRAME,
                unit="meters",
                description=f"position of {name}",
                **_times(times),
            )
        )
        for what, columns, unit in (
            ("orientation", slice(3, 7), _UNKNOWN), ("velocity", slice(7, 10), "m/s"),
            ("angular_velocity", slice(10, 13), "rad/s"),
        ):  # fmt: skip
            described = f"{what} of {name} in the world's frame: {', '.join(series.columns[columns])}"
            module.add(
                TimeSeries(
                    name=f"{name}_{what}", data=values[:, columns], unit=unit, description=described,
                    **_times(times),
                )
            )  # fmt: skip
    module.add(places)


def _add_images(file: Any, recording: Recording, topic: str) -> None:
    """Write the images of a camera one by one, to hold only one in memory."""
    times_s = [seconds(message.log_time) for _, message in recording.raw({topic})]
    frames = _frames(recording, topic)
    first = next(frames, None)
    if first is None:
        return
    from hdmf.data_utils import DataChunkIterator

    data = DataChunkIterator(
        data=chain([first], frames), maxshape=(len(times_s), *first.shape), dtype=first.dtype
    )
    file.add_acquisition(
        ImageSeries(
            name=_object_name(topic), data=H5DataIO(data, compression="gzip", chunks=(1, *first.shape)),
            unit=_UNKNOWN, format="raw", description="row, column, RGB or one value",
            **_times(np.array(times_s)),
        )
    )  # fmt: skip


def _frames(recording: Recording, topic: str) -> Iterator[Any]:
    for one in recording.messages({topic}):
        yield values_of(one.message)
