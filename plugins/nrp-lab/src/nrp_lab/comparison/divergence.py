"""Where two runs diverge: the first step that differs by more than rounding, and the first visible one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.messages.cdr import Codec
from nrp_core.recording import (
    Comparison,
    Difference,
    RecordedStep,
    Recording,
    Role,
    nearest_quaternions,
    steps_of,
)
from nrp_lab.comparison.signals import RunSignals

NOISE = 1e-9
"""Numbers of a message are the same if they differ by less than this share of the largest, or of 1."""
VISIBLE = 0.05
"""A signal differs visibly when it differs by this share of its range over both runs."""
_CAUSES_FIRST = Role.VOLTAGE, Role.SINK, Role.PUBLISHED, Role.MODELS, Role.SENSOR, Role.SOURCE
"""The roles of the signals that are compared; the first counts in a tie."""


@dataclass(frozen=True, slots=True)
class Visible:
    """The first signal whose difference is visible.

    Args:
        t_s: time, s.
        signal: the topic and the number in it.
        one, other: its values at that time.
    """

    t_s: float
    signal: str
    one: float
    other: float

    def __str__(self) -> str:
        return f"{self.t_s:g} s: {self.signal} is {self.one:.4g} and {self.other:.4g}"


@dataclass(frozen=True, slots=True)
class Deviation:
    """The largest difference of a signal.

    Args:
        signal: the topic and the number in it.
        largest: the largest difference.
        t_s: its time, s.
        rms: root of the mean square of the difference.
        span: range of the signal over both runs.
    """

    signal: str
    largest: float
    t_s: float
    rms: float
    span: float


@dataclass(frozen=True, slots=True)
class Divergence:
    """Two runs and where they diverge.

    Args:
        one, other: their names.
        steps: number of steps compared.
        first: the first difference above rounding noise, or None.
        visible: the first visible difference, or None.
        is_identical: whether the runs are the same to the last bit.
    """

    one: str
    other: str
    steps: int
    first: Difference | None
    visible: Visible | None
    is_identical: bool = False


def divergence_of(one: RunSignals, other: RunSignals) -> Divergence:
    """Return where two runs diverge."""
    found = first_difference(one.recording, other.recording)
    visible = None if found.is_identical else _visible(one, other)
    return Divergence(one.label, other.label, found.steps, found.first, visible, found.is_identical)


class FirstDifference(NamedTuple):
    """The common part of two recordings.

    Args:
        steps: number of steps compared.
        first: the first difference beyond noise.
        is_identical: whether every bit is equal.
    """

    steps: int
    first: Difference | None
    is_identical: bool


def first_difference(one: Recording, other: Recording) -> FirstDifference:
    """Compare two recordings step by step from the later of their starts, up to a difference beyond noise."""
    exact, coarse, codec = Comparison(), Comparison(noise=NOISE), Codec({})
    for ours, theirs in _together(steps_of(one), steps_of(other)):
        exact.add_recorded(ours, theirs, codec)
        if exact.difference is not None:
            coarse.add_recorded(ours, theirs, codec)
        else:
            coarse.steps += 1
        if coarse.difference is not None:
            break
    return FirstDifference(coarse.steps, coarse.difference, exact.difference is None)


def _together(
    one: Iterator[RecordedStep], other: Iterator[RecordedStep]
) -> Iterator[tuple[RecordedStep, RecordedStep]]:
    """Return the steps of both that end at the same time.

    A recording starts with a state; in a recording that started earlier, a step led to that state.
    """
    ours, theirs = next(one, None), next(other, None)
    begun = ours is None or theirs is None or ours.t_ns == theirs.t_ns
    while ours is not None and theirs is not None:
        if ours.t_ns == theirs.t_ns:
            if begun:
                yield ours, theirs
            begun = True
        ahead = ours.t_ns - theirs.t_ns
        ours, theirs = (ours if ahead > 0 else next(one, None)), (theirs if ahead < 0 else next(other, None))


def deviations(one: RunSignals, other: RunSignals) -> list[Deviation]:
    """Return the difference of each signal that both runs have, the largest share of its range first."""
    found = []
    for signal, times_s, a, b in common_signals(one, other):
        apart = np.abs(a - b)
        at, span = int(apart.argmax()), _span(a, b)
        rms = float(np.sqrt(np.mean(apart**2)))
        found.append(Deviation(signal, float(apart[at]), float(times_s[at]), rms, span))
    return sorted(found, key=lambda d: -(d.rms / d.span if d.span else 0.0))


def _visible(one: RunSignals, other: RunSignals) -> Visible | None:
    first: Visible | None = None
    for signal, times_s, a, b in common_signals(one, other):
        above = np.flatnonzero(np.abs(a - b) > VISIBLE * _span(a, b))
        if len(above) and (first is None or times_s[above[0]] < first.t_s):
            at = above[0]
            first = Visible(float(times_s[at]), signal, float(a[at]), float(b[at]))
    return first


def common_signals(
    one: RunSignals, other: RunSignals
) -> Iterator[tuple[str, FloatArray, FloatArray, FloatArray]]:
    """Return each number that both runs have: its name, times, and values in both."""
    times_s = min(one.times_s, other.times_s, key=len)
    for series in one.numbers.with_role(*_CAUSES_FIRST):
        twin = other.numbers.series.get(series.name)
        if twin is None or twin.columns != series.columns:
            continue
        a, b = one.held(series, times_s), other.held(twin, times_s)
        b = nearest_quaternions(series.columns, a, b)
        for column, name in enumerate(series.columns):
            both = np.isfinite(a[:, column]) & np.isfinite(b[:, column])
            if both.any():
                label = series.name if name in ("data", "value") else f"{series.name}.{name}"
                yield label, times_s[both], a[both, column], b[both, column]


def _span(a: FloatArray, b: FloatArray) -> float:
    return float(max(a.max(), b.max()) - min(a.min(), b.min()))
