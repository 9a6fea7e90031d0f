"""What a figure of a run needs, gathered from its recording."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import from_seconds, seconds
from nrp_core.recording.images import pixels_of
from nrp_core.recording.layout import SCENE, Role
from nrp_core.recording.reading.recording import Recorded, RecordedTopic, Recording
from nrp_core.world.messages.std_msgs import ColorRGBA
from nrp_core.world.messages.visualization_msgs import Marker
from nrp_core.world.rigid.pose import Pose

Rgb = tuple[float, float, float]

_BEFORE_S = 0.1
_UNITS = {"geometry_msgs/msg/Twist": {"linear": "m/s", "angular": "rad/s"}}


@dataclass
class StepSeries:
    """A value over time; between two entries it holds."""

    label: str
    unit: str
    times_s: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)

    def add(self, t_s: float, value: float) -> None:
        """Append a value."""
        self.times_s.append(t_s)
        self.values.append(value)


@dataclass
class Track:
    """Where a model was: times in s, positions in m, headings in rad."""

    times_s: list[float] = field(default_factory=list)
    xs: list[float] = field(default_factory=list)
    ys: list[float] = field(default_factory=list)
    yaws: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Coloured:
    """A time in which a visual had another colour than at the start."""

    visual: str
    since_s: float
    until_s: float
    rgb: Rgb


@dataclass(frozen=True)
class CameraFrame:
    """What a camera saw at a time."""

    t_s: float
    pixels: npt.NDArray[np.uint8]


@dataclass
class Story:
    """A run as a figure tells it.

    Args:
        run: what ``run.json`` says.
        end_s: simulated time of the last message.
        markers: the look of the room and the robots at the start.
        tracks: of every model that can move.
        spikes: by population: ids and times in s.
        sinks: values of devices that listen to neurons.
        commands: numbers that were published, by topic and field.
        colours: by visual: the colour from each time on.
    """

    run: Mapping[str, Any]
    end_s: float = 0.0
    markers: list[Marker] = field(default_factory=list)
    tracks: dict[str, Track] = field(default_factory=dict)
    spikes: dict[str, list[tuple[npt.NDArray[np.uint32], FloatArray]]] = field(default_factory=dict)
    sinks: dict[str, StepSeries] = field(default_factory=dict)
    commands: dict[str, StepSeries] = field(default_factory=dict)
    colours: dict[str, list[tuple[float, Rgb]]] = field(default_factory=dict)

    @classmethod
    def of(cls, recording: Recording) -> Story:
        """Gather the story of a recording."""
        story = cls(recording.run)
        topics = recording.topics
        told = [
            name for name, topic in topics.items() if topic.role not in (Role.CAMERA, Role.SOURCE, Role.RUN)
        ]
        for recorded in recording.messages(told):
            story.end_s = max(story.end_s, seconds(recorded.t_ns))
            story._take(topics[recorded.topic], recorded)
        return story

    def coloured(self) -> list[Coloured]:
        """Return every time in which a visual did not have its first colour."""
        found = []
        for visual, changes in self.colours.items():
            ends = [t_s for t_s, _ in changes[1:]] + [self.end_s]
            first = changes[0][1]
            found += [
                Coloured(visual, since_s, until_s, rgb)
                for (since_s, rgb), until_s in zip(changes, ends, strict=True)
                if rgb != first and until_s > since_s
            ]
        return found

    def name_of(self, visual: str) -> str:
        """Return what people call a visual: the experiment's alias for its colour, or its model."""
        for alias, topic in dict(self.run.get("aliases") or {}).items():
            if topic == f"/{visual}/color":
                return str(alias).strip("/").removesuffix("/color")
        return visual.split("/", maxsplit=1)[0].replace("_", " ")

    # -- one method for each role

    def _take(self, topic: RecordedTopic, recorded: Recorded) -> None:
        message, t_s = recorded.message, seconds(recorded.t_ns)
        match topic.role:
            case Role.SCENE if recorded.topic == SCENE:
                self._take_scene(message.markers)
            case Role.MODELS:
                self._take_models(message, t_s)
            case Role.SPIKES:
                self.spikes.setdefault(message.population, []).append((message.ids, message.times_ms * 1e-3))
            case Role.SINK:
                label = topic.about.get("device", recorded.topic)
                series = self.sinks.setdefault(recorded.topic, StepSeries(label, topic.about.get("unit", "")))
                series.add(t_s, message.data)
            case Role.PUBLISHED if isinstance(message, ColorRGBA):
                visual = recorded.topic.strip("/").removesuffix("/color")
                self.colours.setdefault(visual, []).append((t_s, (message.r, message.g, message.b)))
            case Role.PUBLISHED:
                self._take_numbers(topic, message, t_s)

    def _take_scene(self, markers: list[Marker]) -> None:
        self.markers = markers
        for marker in markers:
            colour = (marker.color.r, marker.color.g, marker.color.b)
            self.colours.setdefault(marker.ns, [(0.0, colour)])

    def _take_models(self, states: Any, t_s: float) -> None:
        for name, pose in zip(states.name, states.pose, strict=True):
            track = self.tracks.setdefault(name, Track())
            turn = pose.orientation
            track.times_s.append(t_s)
            track.xs.append(pose.position.x)
            track.ys.append(pose.position.y)
            track.yaws.append(Pose(orientation=(turn.x, turn.y, turn.z, turn.w)).yaw)

    def _take_numbers(self, topic: RecordedTopic, message: Any, t_s: float) -> None:
        units = _UNITS.get(topic.type_name, {})
        for path, value in numbers_in(message):
            key = f"{topic.name}.{path}"
            unit = units.get(path.split(".")[0], "")
            self.commands.setdefault(key, StepSeries(_label(topic, path), unit)).add(t_s, value)


def _label(topic: RecordedTopic, path: str) -> str:
    return topic.name if path == "data" else f"{topic.name}.{path}"


def numbers_in(message: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Return every number in a message with its dotted path; headers and arrays are left out."""
    for spec in dataclasses.fields(message):
        value, name = getattr(message, spec.name), f"{path}{spec.name}"
        if isinstance(value, (bool, int, float)):
            yield name, float(value)
        elif dataclasses.is_dataclass(value) and spec.name != "header":
            yield from numbers_in(value, f"{name}.")


def moments(story: Story, count: int) -> list[float]:
    """Return so many times that tell a run: its ends, those in which something had another colour, the rest.

    Of a time with another colour the middle is taken, and the moment before it ends.
    """
    times = {0.0, story.end_s}
    for one in story.coloured():
        middle_s = (one.since_s + one.until_s) / 2
        for t_s in (middle_s, max(middle_s, one.until_s - _BEFORE_S)):
            if len(times) < count:
                times.add(t_s)
    fixed = np.array(sorted(times))
    gaps, parts = np.diff(fixed), np.ones(len(fixed) - 1, int)
    while len(gaps) and parts.sum() < count - 1:
        parts[np.argmax(gaps / parts)] += 1
    between = [np.linspace(fixed[i], fixed[i + 1], n, endpoint=False) for i, n in enumerate(parts)]
    return [float(t_s) for t_s in np.concatenate([*between, fixed[-1:]])]


def pictures(recording: Recording, times_s: Sequence[float]) -> list[CameraFrame]:
    """Return what the first camera saw nearest to some times; fewer where it took fewer."""
    cameras = recording.with_role(Role.CAMERA)
    if not cameras:
        return []
    topic = cameras[0].name
    taken = np.array([message.log_time for _, message in recording.raw({topic})])
    if not len(taken):
        return []
    chosen = {int(taken[np.argmin(np.abs(taken - from_seconds(t_s)))]) for t_s in times_s}
    return [
        CameraFrame(seconds(recorded.t_ns), pixels_of(recorded.message))
        for recorded in recording.messages({topic})
        if recorded.t_ns in chosen
    ]
