"""State variables that are recorded while the exact mode runs, inside compiled code."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from nrp_brain_event.kernels import READABLE, read, run
from nrp_brain_event.records import DONE, Array
from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core.brain.devices.sinks import Trace
from nrp_core.clock import NS_PER_MS


class Plan(NamedTuple):
    """A run that halts where samples are taken.

    Args:
        stops, ends: times (ms), and the next number after each, see :func:`nrp_brain_event.kernels.run`.
        readings: samples in the order of their times: index of the stop, variable, first neuron, number of
            neurons, place of the sample; shape ``(n, 5)``.
        neurons: global ids, those of each trace one after another.
        done: number of stops and of readings that have passed, shape ``(2,)``.
    """

    stops: FloatArray
    ends: FloatArray
    readings: IntArray
    neurons: IntArray
    done: IntArray


def planned(traces: Sequence[Trace], since_ns: int, until_ns: int, patience_ns: int) -> Plan:
    """Return a run with the samples of traces, which also halts at least every ``patience_ns``."""
    halts = np.append(np.arange(since_ns + patience_ns, until_ns, patience_ns), until_ns)
    stops_ns = np.concatenate([halts, *(trace.times_ns for trace in traces)])
    stops_ns = stops_ns[:1] if (stops_ns == until_ns).all() else np.unique(stops_ns)  # one in a short run
    rows, first, place = [], 0, 0
    for trace in traces:
        n, m = trace.shape
        own = np.empty((n, 5), np.int64)
        own[:, 0] = np.searchsorted(stops_ns, trace.times_ns)
        own[:, 1:4] = READABLE.index(trace.variable), first, m
        own[:, 4] = place + m * np.arange(n)
        rows.append(own)
        first, place = first + m, place + n * m
    readings = np.concatenate(rows)
    readings = np.ascontiguousarray(readings[np.argsort(readings[:, 0], kind="stable")])
    stops = stops_ns / NS_PER_MS
    neurons = np.concatenate([trace.neurons for trace in traces])
    return Plan(stops, np.nextafter(stops, inf), readings, neurons, np.zeros(2, np.int64))


@jit
def run_reading(
    places: Array, stops: Array, ends: Array, readings: Array, neurons: Array, done: Array,
    last: int, out: Array,
) -> int:  # fmt: skip
    """Follow a plan up to its stop number ``last``; returns as :func:`nrp_brain_event.kernels.run`."""
    while done[0] < last:
        status = run(places, stops[done[0]], ends[done[0]])
        if status != DONE:
            return int(status)
        while done[1] < len(readings) and readings[done[1], 0] == done[0]:
            variable, first = readings[done[1], 1], readings[done[1], 2]
            n, place = readings[done[1], 3], readings[done[1], 4]
            read(places, neurons[first : first + n], variable, out[place : place + n])
            done[1] += 1
        done[0] += 1
    return DONE
