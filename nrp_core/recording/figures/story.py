"""The data for the figures of a run, collected from its recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import acos, dist, inf
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.observables import topic_of
from nrp_core.recording.layout import SCENE, Role
from nrp_core.recording.reading.mcap_messages import RecordedTopic
from nrp_core.recording.reading.reader import Recorded, RecordingReader
from nrp_core.recording.reading.shapes import RecordedScene
from nrp_core.recording.reading.tables import number_values
from nrp_core.scene.rigid import Pose
from nrp_core.world.model_states import pose_of, transform_pose

Rgb = tuple[float, float, float]

_REACH_M = 0.3


@dataclass
class StepSeries:
    """A value over time; between two entries it holds."""

    label: str
    unit: str
    times_s: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)

    def add(self, t_s: float, value: float, begin_s: float = 0.0) -> None:
        """Append a value; a value from before the start replaces the previous one."""
        if t_s < begin_s:
            self.times_s.clear()
            self.values.clear()
        self.times_s.append(max(t_s, begin_s))
        self.values.append(value)


@dataclass
class Track:
    """The trajectory of a model: times in s, positions in m, headings in rad."""

    times_s: list[float] = field(default_factory=list)
    xs: list[float] = field(default_factory=list)
    ys: list[float] = field(default_factory=list)
    yaws: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Coloured:
    """A period in which a visual had another colour than at the start."""

    visual: str
    since_s: float
    until_s: float
    rgb: Rgb


@dataclass
class Story:
    """The data of a run for its figures.

    Args:
        run: the contents of ``run.json``.
        begin_s, end_s: the period that is shown; it ends at the last message at the latest.
        activity: motion of the links since the previous message on ``/tf``, by time in s.
        scene: the shapes of the room and the robots.
        first_poses, last_poses: the first and last pose of every moving frame.
        tracks: the track of every movable model.
        spikes: by population: ids and times in s.
        voltages: membrane voltages, by topic and cell.
        sinks: values of devices that record neurons.
        commands: numbers that were published, by topic and field, except observables.
        observables: those of the experiment's observables.
        colours: the colour of each visual from each time on.
    """

    run: Mapping[str, Any]
    begin_s: float = 0.0
    end_s: float = 0.0
    activity: list[tuple[float, float]] = field(default_factory=list)
    scene: RecordedScene = field(default_factory=RecordedScene)
    first_poses: dict[str, Pose] = field(default_factory=dict)
    last_poses: dict[str, Pose] = field(default_factory=dict)
    tracks: dict[str, Track] = field(default_factory=dict)
    spikes: dict[str, list[tuple[npt.NDArray[np.uint32], FloatArray]]] = field(default_factory=dict)
    voltages: dict[str, StepSeries] = field(default_factory=dict)
    sinks: dict[str, StepSeries] = field(default_factory=dict)
    commands: dict[str, StepSeries] = field(default_factory=dict)
    observables: dict[str, StepSeries] = field(default_factory=dict)
    colours: dict[str, list[tuple[float, Rgb]]] = field(default_factory=dict)

    @classmethod
    def of(cls, recording: RecordingReader, begin_s: float = 0.0, end_s: float = inf) -> Story:
        """Collect the data of a recording between two times.

        Raises:
            ExperimentError: the recording has no message between them.
        """
        story = cls(recording.run, begin_s)
        topics = recording.topics
        names = [
            name
            for name, topic in topics.items()
            if topic.role not in (Role.CAMERA, Role.SOURCE, Role.MUSCLES, Role.RUN)
        ]
        for recorded in recording.messages(names):
            t_s = seconds(recorded.t_ns)
            if t_s > end_s:
                break
            story.end_s = max(story.end_s, t_s)
            story._take(topics[recorded.topic], recorded)
        if begin_s and story.end_s <= begin_s:
            message = f"it has no messages from {begin_s:g} s on: it ends at {story.end_s:g} s"
            raise ExperimentError(message, path=recording.file)
        return story

    def coloured(self) -> list[Coloured]:
        """Return every period in which a visual did not have its first colour."""
        found = []
        for visual, changes in self.colours.items():
            ends = [t_s for t_s, _ in changes[1:]] + [self.end_s]
            first = changes[0][1]
            found += [
                Coloured(visual, max(since_s, self.begin_s), until_s, rgb)
                for (since_s, rgb), until_s in zip(changes, ends, strict=True)
                if rgb != first and until_s > max(since_s, self.begin_s)
            ]
        return found

    def name_of(self, visual: str) -> str:
        """Return a readable name of a visual: the experiment's alias for its colour, or its model."""
        for alias, topic in dict(self.run.get("aliases") or {}).items():
            if topic == f"/{visual}/color":
                return str(alias).strip("/").removesuffix("/color")
        return visual.split("/", maxsplit=1)[0].replace("_", " ")

    @property
    def span_s(self) -> tuple[float, float]:
        """The period that is shown, never empty."""
        return self.begin_s, self.end_s if self.end_s > self.begin_s else self.begin_s + 1.0

    def share_of(self, t_s: float) -> float:
        """Return the position of a time in the period that is shown, 0 to 1."""
        begin_s, end_s = self.span_s
        return min(max((t_s - begin_s) / (end_s - begin_s), 0.0), 1.0)

    # -- one method for each role

    def _take(self, topic: RecordedTopic, recorded: Recorded) -> None:
        """Add a message; a value from before the period holds until the next one."""
        message, t_s = recorded.message, seconds(recorded.t_ns)
        early = t_s < self.begin_s
        match topic.role:
            case Role.SCENE if recorded.topic == SCENE:
                self._take_scene(message)
            case Role.TRANSFORMS:
                self._take_transforms(message, t_s)
            case Role.MODELS:
                self._take_models(message, t_s)
            case Role.SPIKES if not early:
                self.spikes.setdefault(message.population, []).append((message.ids, message.times_ms * 1e-3))
            case Role.VOLTAGE:
                for cell, value in zip(topic.elements, message.data, strict=True):
                    series = StepSeries(f"{topic.about['population']}[{cell}]", topic.about["unit"])
                    self.voltages.setdefault(f"{topic.name}.{cell}", series).add(t_s, value, self.begin_s)
            case Role.SINK:
                label = topic.about.get("device", recorded.topic)
                series = self.sinks.setdefault(recorded.topic, StepSeries(label, topic.about.get("unit", "")))
                series.add(t_s, message.data, self.begin_s)
            case Role.PUBLISHED if isinstance(message, ColorRGBA):
                visual = recorded.topic.strip("/").removesuffix("/color")
                self.colours.setdefault(visual, []).append((t_s, (message.r, message.g, message.b)))
            case Role.PUBLISHED:
                self._take_numbers(topic, message, t_s)

    def _take_scene(self, message: Any) -> None:
        self.scene.take(message)
        for shape in self.scene.shapes:
            self.colours.setdefault(shape.visual, [(0.0, shape.rgba[:3])])

    def _take_transforms(self, message: Any, t_s: float) -> None:
        moved = 0.0
        for each in message.transforms:
            name, pose = each.child_frame_id, transform_pose(each.transform)
            moved += _motion(self.last_poses.get(name, pose), pose)
            self._take_frame(name, pose, t_s)
        if t_s >= self.begin_s:
            self.activity.append((t_s, moved))

    def _take_frame(self, name: str, pose: Pose, t_s: float) -> None:
        if t_s <= self.begin_s:
            self.first_poses[name] = pose
        self.first_poses.setdefault(name, pose)
        self.last_poses[name] = pose

    def _take_models(self, states: Any, t_s: float) -> None:
        for name, pose in zip(states.name, states.pose, strict=True):
            at = pose_of(pose)
            self._take_frame(name, at, t_s)
            if t_s >= self.begin_s:
                track = self.tracks.setdefault(name, Track())
                track.times_s.append(t_s)
                track.xs.append(at.position[0])
                track.ys.append(at.position[1])
                track.yaws.append(at.yaw)

    def _take_numbers(self, topic: RecordedTopic, message: Any, t_s: float) -> None:
        for one in number_values(message, topic.elements):
            unit = one.unit or topic.about.get("unit", "")
            series = StepSeries(_label(topic, one.path), unit)
            group = self.observables if topic.name.startswith(topic_of("")) else self.commands
            group.setdefault(f"{topic.name}.{one.path}", series).add(t_s, one.value, self.begin_s)


def _motion(before: Pose, now: Pose) -> float:
    """Return the motion of a link, m: its displacement, and its rotation at a distance of 0.3 m."""
    turned = abs(sum(a * b for a, b in zip(before.orientation, now.orientation, strict=True)))
    return dist(before.position, now.position) + _REACH_M * 2 * acos(min(turned, 1.0))


def _label(topic: RecordedTopic, path: str) -> str:
    field = path.removeprefix("data").removeprefix(".")
    return f"{topic.name}.{field}" if field else topic.name
