"""Recorded data as objects of pandas and Neo."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import seconds
from nrp_core.errors import CapabilityError
from nrp_core.recording.reading.columns import values_in
from nrp_core.recording.reading.mcap_messages import RecordedTopic

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
    for t_ns, message in messages:
        row: dict[str, Any] = {}
        for one in values_in(message):
            row[one.path] = one.value
            units.setdefault(one.path, one.unit or topic.about.get("unit", ""))
        times_s.append(seconds(t_ns))
        rows.append(row)
    table = pandas.DataFrame(rows, index=pandas.Index(times_s, dtype=float, name=TIME), columns=list(units))
    table.attrs = {"topic": topic.name, "type": topic.type_name, "units": units}
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
