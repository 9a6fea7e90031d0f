"""The interface of a metric, and distances between curves and between spike trains.

::

    class Stops(ScalarMetric):
        name, title = "stops", "Stops"

        def values(self, run):
            return {robot: float(...) for robot in run.robots}
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.errors import BackendLoadError, ExperimentError, did_you_mean
from nrp_core.experiment import Experiment
from nrp_core.registry import Registry
from nrp_core.utilities import checks_arguments, jit, require_fields
from nrp_lab.comparison.signals import RunSignals


def dtw_distance(one: FloatArray, other: FloatArray, band: float = 0.2) -> float:
    """Return the mean distance along the best alignment of two curves in time (dynamic time warping).

    Sakoe and Chiba 1978, IEEE Trans. ASSP 26:43, with their symmetric steps and their band.

    Args:
        one: points, shape ``(n, dimensions)``.
        other: the same; the number of points may differ.
        band: largest difference in time, as a share of the length.
    """
    reach = max(int(band * max(len(one), len(other))), abs(len(one) - len(other)), 1)
    return float(_dtw(one, other, reach)) / (len(one) + len(other))


@jit
def _dtw(one: FloatArray, other: FloatArray, reach: int) -> float:
    """Return the smallest sum of distances along a path; a diagonal step counts twice."""
    n, m, dimensions = one.shape[0], other.shape[0], one.shape[1]
    before, row = np.full(m + 1, np.inf), np.full(m + 1, np.inf)
    before[0] = 0.0
    for i in range(n):
        row[:] = np.inf
        for j in range(max(0, i - reach), min(m, i + reach + 1)):
            squares = 0.0
            for k in range(dimensions):
                squares += (one[i, k] - other[j, k]) ** 2
            d = np.sqrt(squares)
            row[j + 1] = min(before[j + 1] + d, row[j] + d, before[j] + 2 * d)
        before, row = row, before
    return float(before[m])


def filtered_trains(
    trains_s: Sequence[FloatArray], end_s: float, tau_s: float, step_s: float = 0.005
) -> FloatArray:
    """Return spike trains as curves whose distance is van Rossum's.

    Every spike is followed by an exponential decay; van Rossum 2001, Neural Comput. 13:751.

    Args:
        trains_s: spike times of each neuron, s.
        end_s: end of the curves, s.
        tau_s: time constant of the decay, s; much smaller shifts have no effect on the distance.
        step_s: sampling interval of the curves, s.

    Returns:
        shape ``(n_trains, n_samples)``, scaled so that a single spike has a norm of 1.
    """
    samples = int(np.ceil(end_s / step_s)) + 1
    curves = np.zeros((len(trains_s), samples))
    for curve, train in zip(curves, trains_s, strict=True):
        index = np.minimum(np.ceil(train / step_s).astype(int), samples - 1)
        np.add.at(curve, index, np.exp(-(index * step_s - train) / tau_s))
    from scipy.signal import lfilter

    decay = float(np.exp(-step_s / tau_s))
    filtered: FloatArray = lfilter([1.0], [1.0, -decay], curves, axis=1)
    filtered *= np.sqrt(2 * step_s / tau_s)
    return filtered


@dataclass(frozen=True, slots=True)
class Margin:
    """The largest difference that does not matter.

    Args:
        amount: the difference.
        in_sd: whether it is in standard deviations of the spread from seed to seed, else in the metric's
            own unit.
        at_most: upper limit, in the metric's own unit.
        at_least: lower limit, in the metric's own unit, below which users of the robot do not notice it.
    """

    amount: float = 1.0
    in_sd: bool = True
    at_most: float | None = None
    at_least: float = 0.0

    def __post_init__(self) -> None:
        require_fields(self, "Margin")

    def within(self, sd: float) -> float:
        """Return the margin in the metric's unit, for a spread in that unit."""
        margin = max(self.amount * sd if self.in_sd else self.amount, self.at_least)
        return margin if self.at_most is None else min(margin, self.at_most)

    @classmethod
    @checks_arguments()
    def parse(cls, text: str, unit: str = "") -> Margin:
        """Read ``0.5``, with or without its unit, or ``2sd``.

        Raises:
            ValueError: the text is neither, or not above 0.
        """
        number, sd = text.strip(), text.strip().lower().endswith("sd")
        number = number[: -len("sd")] if sd else number.removesuffix(unit)
        try:
            amount = float(number)
        except ValueError:
            amount = 0.0
        if not 0 < amount < float("inf"):
            example = f"0.5 {unit}".strip()
            raise ValueError(f"a margin is a number above 0, as {example} or 2sd, not '{text}'")
        return cls(amount, in_sd=sd)


class Metric(ABC):
    """A property of a run, measured for each of its parts (robots, events, ...).

    Attributes:
        name: name on the command line.
        title: name in a report.
        unit: unit of its values.
        is_finding: whether it is part of the experiment's finding, not a detail of how it came about.
        is_compared: whether ``nrp diff`` compares it. A metric that repeats others is only for sweeps,
            searches and benchmarks: a difference is harder to prove among more measures.
        margin: the default margin.
        needs_recording: whether it needs more of a run than its result and its settings.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    unit: ClassVar[str] = ""
    is_finding: ClassVar[bool] = False
    is_compared: ClassVar[bool] = True
    margin: ClassVar[Margin] = Margin()
    needs_recording: ClassVar[bool] = True

    def resolution(self, run: RunSignals) -> float:
        """Return the smallest difference that the metric can resolve, in its unit; no margin is smaller."""
        return 0.0


class ScalarMetric(Metric):
    """A number for each part of a run.

    Attributes:
        is_share: whether it is always 0 or 1.
    """

    is_share: ClassVar[bool] = False

    def parts(self, experiment: Experiment) -> Collection[str] | None:
        """Return the parts that runs of an experiment have; None if they are known only after a run."""
        return None

    @abstractmethod
    def values(self, run: RunSignals) -> Mapping[str, float | None]:
        """Return the value of every part; None for a part without a value in this run."""

    def units(self, run: RunSignals) -> Mapping[str, str]:
        """Return the units of parts whose unit is not that of the metric."""
        return {}


class DistanceMetric(Metric):
    """A distance between two runs, for each part."""

    @abstractmethod
    def features(self, run: RunSignals) -> Mapping[str, Any]:
        """Return the features that distances are computed from, for every part; called once for a run."""

    @abstractmethod
    def distance(self, one: Any, other: Any) -> float:
        """Return the distance between the features of one part of two runs."""


METRICS: Registry[Metric] = Registry("nrp_core.metrics", "metric", [ScalarMetric, DistanceMetric])


def all_metrics() -> list[Metric]:
    """Return the metrics of all installed packages; the finding's first.

    Raises:
        BackendError: one cannot be used.
    """
    found = METRICS.load_all()
    for name, metric in found.items():
        own = getattr(metric, "name", None)
        if own != name:
            raise BackendLoadError(f"metric '{name}' of {METRICS.provider(name)} calls itself '{own}'")
    return sorted(found.values(), key=lambda metric: (not metric.is_finding, metric.name))


class HasMargin(Protocol):
    """A metric, or a measure of engines."""

    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def margin(self) -> Margin: ...


@dataclass(frozen=True, slots=True)
class Margins:
    """The margins that were set, by name and by ``name/part``; everything else has its default."""

    given: Mapping[str, Margin] = field(default_factory=dict)

    def of(self, measured: HasMargin, part: str) -> Margin:
        """Return the margin of a part: its own, that of all parts, or the default."""
        keys = (f"{measured.name}/{part}", measured.name)
        return next((self.given[key] for key in keys if key in self.given), measured.margin)

    def require_parts(self, parts: Iterable[str]) -> None:
        """Refuse a margin of a part (``name/part``) that was not measured.

        Raises:
            ExperimentError: one was found.
        """
        known = list(parts)
        for key in self.given:
            if "/" in key and key not in known:
                hint = did_you_mean(key, known)
                raise ExperimentError(f"'{key}' was not measured, so it cannot have a margin{hint}")

    def require_possible(self, metrics: Iterable[Metric], experiment: Experiment) -> None:
        """Refuse a margin of a part that no run of an experiment will have, before the runs.

        Raises:
            ExperimentError: one was found.
        """
        scalar = (metric for metric in metrics if isinstance(metric, ScalarMetric))
        parts = {metric.name: metric.parts(experiment) for metric in scalar}
        given = {
            key: value for key, value in self.given.items() if parts.get(key.partition("/")[0]) is not None
        }
        known = (f"{name}/{part}" for name, found in parts.items() for part in found or ())
        Margins(given).require_parts(known)

    @classmethod
    def parse(cls, texts: Iterable[str], known: Iterable[HasMargin], *, in_sd: bool = True) -> Margins:
        """Read ``name=value`` and ``name/part=value``, values as ``0.5``, ``0.5 s`` or ``2sd``.

        Args:
            texts: the margins.
            known: the metrics, or the measures of engines.
            in_sd: whether several runs exist, so that standard deviations are defined.

        Raises:
            ValueError: one is written differently, or the metric does not exist.
        """
        units = {one.name: one.unit for one in known}
        margins: dict[str, Margin] = {}
        for text in texts:
            key, equals, value = text.rpartition("=")
            if not equals:
                raise ValueError(f"a margin is written METRIC=VALUE, not '{text}'")
            name = key.partition("/")[0]
            if name not in units:
                raise ValueError(f"there is no metric '{name}'{did_you_mean(name, list(units))}")
            margins[key] = Margin.parse(value, units[name])
            if margins[key].in_sd and not in_sd:
                raise ValueError(
                    f"'{name}' compares single runs: its margin is in {units[name]}, not '{value}'"
                )
        return cls(margins)
