"""The recording of one run as arrays over the steps of the loop, so that runs can be compared."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from nrp_core.brain import FloatArray, IntArray
from nrp_core.clock import seconds
from nrp_core.errors import LifecycleError
from nrp_core.experiment import recorded_judgement
from nrp_core.findings import Weight
from nrp_core.recording import Numbers, Recording, Role, Series, groups_of
from nrp_core.utilities import checks_arguments, join_with_limit
from nrp_core.world.model_states import MODEL_STATES


class RunSignals:
    """One recorded run, or a part of it.

    Args:
        recording: its recording; of a run without one, what ``run.json`` would hold: it has a result and
            settings, but no signals.
        window_s: start and end, s; by default all of the recording.

    Attributes:
        run: the contents of ``run.json``.
    """

    @checks_arguments()
    def __init__(
        self, recording: Recording | dict[str, Any], window_s: tuple[float, float] | None = None
    ) -> None:
        self._recording = recording
        self.run: dict[str, Any] = recording if isinstance(recording, dict) else recording.run
        self._window_s = window_s

    @property
    def recording(self) -> Recording:
        """The recording.

        Raises:
            LifecycleError: the run was not recorded.
        """
        if isinstance(self._recording, dict):
            raise LifecycleError("the run was not recorded, so it has a result, but no signals")
        return self._recording

    def between(self, begin_s: float, end_s: float) -> RunSignals:
        """Return a part of the run; its result remains that of the whole run."""
        part = RunSignals(self.recording, (begin_s, end_s))
        part.numbers = self.numbers
        return part

    @property
    def label(self) -> str:
        """Backends, controls of the wiring and seed as a text."""
        controls = (self.settings.get("brain") or {}).get("controls") or ()
        wirings = [f"{kind}: {what}" for control in controls for kind, what in control.items() if what]
        return ", ".join([f"{self.brain} x {self.world}", *wirings, f"seed {self.run.get('seed', '?')}"])

    @property
    def brain(self) -> str:
        """Name of the brain backend."""
        return str((self.run.get("brain") or {}).get("backend", "?"))

    @property
    def world(self) -> str:
        """Name of the world backend."""
        return str((self.run.get("world") or {}).get("backend", "?"))

    @property
    def failed(self) -> bool:
        """Whether it ended early."""
        return bool(self.result.get("error"))

    @property
    def result(self) -> Mapping[str, Any]:
        """The result of the run; empty if the recording was cut."""
        return self.run.get("result") or {}

    @property
    def settings(self) -> Mapping[str, Any]:
        """The experiment as plain data."""
        return self.run.get("settings") or {}

    @property
    def step_s(self) -> float:
        """Period of the loop, s."""
        return seconds(int(self.settings.get("timestep") or 20_000_000))

    @cached_property
    def numbers(self) -> Numbers:
        """All numbers as recorded."""
        return Numbers.of(self.recording)

    @property
    def begin_s(self) -> float:
        """Simulated time of the start, s; above 0 in a recording that continues another."""
        return self.numbers.begin_s if self._window_s is None else self._window_s[0]

    @property
    def end_s(self) -> float:
        """Simulated time of the end, s."""
        return self.numbers.end_s if self._window_s is None else self._window_s[1]

    @property
    def duration_s(self) -> float:
        """Duration, s."""
        return self.end_s - self.begin_s

    @cached_property
    def times_s(self) -> FloatArray:
        """The start and the ends of all steps, s."""
        first, last = (round(t_s / self.step_s) for t_s in (self.begin_s, self.end_s))
        times: FloatArray = np.arange(first, last + 1, dtype=float) * self.step_s
        return times

    def held(self, series: Series, times_s: FloatArray | None = None) -> FloatArray:
        """Return the values of a series at given times; a value holds until the next, NaN before the first.

        Args:
            series: a series of this run.
            times_s: times, s; by default the ends of all steps.

        Returns:
            Shape ``(n_times, columns)``.
        """
        at_s = (self.times_s if times_s is None else times_s) + self.step_s * 1e-3
        index = np.searchsorted(series.times_s, at_s, side="right") - 1
        return np.where(index[:, None] >= 0, series.values[np.maximum(index, 0)], np.nan)

    # -- the body

    @cached_property
    def robots(self) -> list[str]:
        """Names of the robots; for a foreign recording, of all models that move."""
        moving = [name.removeprefix(f"{MODEL_STATES}/") for name in self._models]
        named = list((self.settings.get("world") or {}).get("robots") or {})
        return [name for name in moving if name in named] or moving

    def motion(self, robot: str) -> Series:
        """Return the pose and the velocity of a robot."""
        return self._models[f"{MODEL_STATES}/{robot}"]

    @property
    def _models(self) -> dict[str, Series]:
        return {one.name: one for one in self.numbers.with_role(Role.MODELS)}

    # -- the brain

    @cached_property
    def groups(self) -> dict[str, tuple[str, IntArray]]:
        """Populations and named groups of neurons: population, and ids in it."""
        found = {label: (label, np.arange(self.numbers.size_of(label))) for label in self.numbers.spikes}
        for name, members in groups_of(self.run).items():
            for label, ids in members.items():
                if label in self.numbers.spikes:
                    found[name if len(members) == 1 else f"{name}/{label}"] = label, np.array(ids)
        return found

    def trains_s(self, group: str) -> list[FloatArray]:
        """Return the spike times of each neuron of a group, s since the start."""
        label, ids = self.groups[group]
        by_neuron = self._trains[label]
        return [by_neuron[i] for i in ids]

    @cached_property
    def _trains(self) -> dict[str, list[FloatArray]]:
        """All spike trains by population."""
        trains = {}
        for label, (ids, times_ms) in self.numbers.spikes.items():
            within = (times_ms > self.begin_s * 1e3) & (times_ms <= self.end_s * 1e3)
            ids, times_s = ids[within], times_ms[within] * 1e-3 - self.begin_s
            order = np.lexsort((times_s, ids))
            cuts = np.searchsorted(ids[order], np.arange(1, self.numbers.size_of(label)))
            trains[label] = np.split(times_s[order], cuts)
        return trains


_MAX_NAMED = 3


def incompleteness(runs: Mapping[str, RunSignals]) -> list[str]:
    """Return a sentence for each reason why runs are not complete, with the runs that it concerns.

    Args:
        runs: the runs by their names.
    """
    concerned: dict[str, list[str]] = {}
    for name, run in runs.items():
        if reason := missing_from(run):
            concerned.setdefault(reason, []).append(name)
    return [
        f"not complete: {join_with_limit(names, _MAX_NAMED)}: {reason}" for reason, names in concerned.items()
    ]


def missing_from(run: RunSignals) -> str:
    """Return the reasons why a recorded run is not complete; an empty text if it is complete."""
    judgement = recorded_judgement(run.run, run.end_s)
    groups = judgement.groups if judgement else []
    return "; ".join(group.headline for group in groups if group.weight is Weight.INCOMPLETE)
