"""The description of a recorded run, without its messages."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from nrp_cockpit.session.described import role_of
from nrp_cockpit.session.findings import finding_data, timeline_data
from nrp_cockpit.session.groups import groups_data
from nrp_cockpit.session.recorded_functions import recorded_functions
from nrp_cockpit.session.reports import shares_data
from nrp_cockpit.streaming.recorded import SCENE_TYPE
from nrp_cockpit.streaming.stored import StoredMessages
from nrp_core.clock import NS_PER_MS, seconds
from nrp_core.errors import ExperimentError, NrpError, TopicError
from nrp_core.experiment import Experiment, Verdict, recorded_judgement
from nrp_core.findings import Code, Finding, Level
from nrp_core.messages.cdr import Codec
from nrp_core.messages.foxglove_msgs import SceneEntity
from nrp_core.recording import RUN_NAME, RecordedTopic, Recording, Role
from nrp_core.recording.folder.recording_folder import recorded_experiment
from nrp_core.recording.layout import CALLED, SCENE, WORLD_FRAME, spikes_topic

FIXED = "a recording cannot be changed; branch a run from it with nrp replay --from"
"""Why requests that change a run are refused."""
_TIMESTEP_NS = 20 * NS_PER_MS
"""The timestep of a recording that does not state its own."""


class RecordedRun:
    """A run as its recording describes it: its parts and its result.

    No code of the run is executed. Unreadable parts are missing and listed in :attr:`problems`.

    Args:
        recording: the recording.
        messages: of the recording.

    Attributes:
        problems: the findings about the run, and about its unreadable parts.
    """

    def __init__(self, recording: Recording, messages: StoredMessages) -> None:
        self._folder, self._end_s = recording.folder, seconds(messages.span_ns[1])
        self._topics = topics = messages.topics
        self.problems: list[Finding] = []
        self._edits = list(self._edits_data(messages))
        try:
            self._about = recording.run
        except ExperimentError:
            self._about = {}  # a check of the recording reports the error
        self._settings: dict[str, Any] = self._about.get("settings") or {}
        self.result: dict[str, Any] = self._about.get("result") or {}
        self._experiment = self._read_experiment(recording)
        if SCENE in topics and topics[SCENE].type_name != SCENE_TYPE:
            message = "the scene is not shown: an earlier version recorded it in another format"
            self.problems.append(Finding(Code.NRP284, message, Level.NOTE))
        self._judgement = recorded_judgement(self._about, self._end_s)
        self.problems += () if self._judgement is None else self._judgement.problems

    @property
    def neighbours(self) -> list[str]:
        """The names of the other recordings in the same folder."""
        own = self._folder.absolute()
        found = (file.parent.name for file in own.parent.glob(f"*/{RUN_NAME}"))
        return sorted(name for name in found if name != own.name)

    @property
    def timestep_ns(self) -> int:
        """The simulated time of a step."""
        return int(self._settings.get("timestep") or _TIMESTEP_NS)

    def experiment_data(self, entities: list[SceneEntity]) -> dict[str, Any]:
        """Return the parts of the run.

        Args:
            entities: of its scene at the beginning.
        """
        brain, world = self._about.get("brain") or {}, self._about.get("world") or {}
        topics = [each for each in self._topics.values() if each.role in _DIRECTIONS]
        populations = brain.get("populations") or {}
        sizes = {label: one["size"] for label, one in populations.items()}
        return {
            "name": str(self._about.get("experiment") or self._folder.name),
            "file": str(self._folder),
            "brain": brain.get("backend", ""),
            "world": world.get("backend", ""),
            "seed": self._about.get("seed", 0),
            "duration_s": self._end_s,
            "timestep_s": seconds(self.timestep_ns),
            "source": "recording",
            "capabilities": dict.fromkeys(("snapshot", "place", "push", "functions"), FIXED)
            | {"step_back": True},
            "topics": [_topic_data(each) for each in topics],
            "robots": list((self._settings.get("world") or {}).get("robots") or ()),
            "populations": list(self._populations(populations)),
            "groups": groups_data(brain.get("views") or {}, sizes),
            "projections": brain.get("projections") or [],
            "devices": list(self._devices(populations)),
            "bodies": list(_bodies(entities, [each.name for each in topics])),
            "mounts": world.get("mounts") or [],
            "lights": world.get("lights") or [],
        }

    def functions_data(self) -> dict[str, Any]:
        """Return its transfer functions and their files."""
        paths = self._experiment.transfer_functions if self._experiment else ()
        return recorded_functions(paths, self.result.get("failures") or ())

    def timeline_data(self) -> dict[str, Any]:
        """Return events, interventions, criteria and failures."""
        past = {"snapshots": [], "automatic_s": [], "edits": self._edits}
        events, failures = self.result.get("events") or {}, self.result.get("failures") or []
        if self._experiment is None:
            found: dict[str, Any] = {
                "events": [{"name": name, "t_s": t_s, "waits_for": ""} for name, t_s in events.items()],
                "interventions": [], "criteria": [], "failures": [], **past,
            }  # fmt: skip
        else:
            criteria = {name: Verdict(**one) for name, one in (self.result.get("criteria") or {}).items()}
            found = timeline_data(self._experiment, events, criteria, failures, past)
        return found | {"duration_s": self._end_s}

    def findings_data(self) -> list[dict[str, Any]]:
        """Return the findings about the run and about its recording."""
        return [finding_data(each) for each in self.problems]

    def status_data(self) -> dict[str, Any]:
        """Return its state and result."""
        result = self.result
        error = result.get("error")
        return {
            "wall_s": result.get("wall_time_s", 0.0),
            "recording": None,
            "recorded": str(self._folder),
            "share": shares_data(result.get("time_share") or {}),
            "error": None if error is None else {"message": str(error), "file": None, "line": None},
            "passed": None if self._judgement is None else self._judgement.passed,
            "complete": self._judgement is not None and self._judgement.complete,
        }

    def _read_experiment(self, recording: Recording) -> Experiment | None:
        try:
            return recorded_experiment(recording)
        except NrpError as error:
            message = f"the experiment of the recording cannot be read: {error}"
            self.problems.append(Finding(Code.NRP284, message, Level.WARNING))
            return None

    def _edits_data(self, messages: StoredMessages) -> Iterator[dict[str, Any]]:
        """Yield times and names of recorded changes from outside; their arguments, pickles, stay closed."""
        topic = messages.topics.get(CALLED)
        if topic is None:
            return
        codec = Codec({topic.type_name: topic.definition})
        for t_ns, data in messages.timed(CALLED, -1, messages.span_ns[1]):
            try:
                name = codec.decode(data, topic.type_name).name
            except TopicError as error:
                message = f"the change from outside at {seconds(t_ns):g} s is damaged: {error}"
                self.problems.append(Finding(Code.NRP284, message, Level.WARNING))
                continue
            yield {"t_s": seconds(t_ns), "name": _EDITS.get(name, name.replace("_", " "))}

    def _populations(self, known: Mapping[str, Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
        driven, read = self._neurons(Role.SOURCE), self._neurons(Role.SINK)
        excluded = (self._settings.get("recording") or {}).get("exclude") or ()
        first = 0
        for label, one in known.items():
            ids = range(first, first + one["size"])
            is_source = str(one["cell_type"]).startswith("SpikeSource")
            yield {
                "label": label,
                "size": one["size"],
                "first": first,
                "cell": one["cell_type"],
                "role": role_of(is_source, not driven.isdisjoint(ids), not read.isdisjoint(ids)),
                "positions": None,
                "placed": False,
                "silent": spikes_topic(label) not in self._topics and label not in excluded,
            }
            first += one["size"]

    def _neurons(self, role: Role) -> set[int]:
        """Return the ids of the neurons that devices of a role are attached to."""
        found = (json.loads(each.about["neurons"]) for each in self._topics.values() if each.role == role)
        return {neuron for neurons in found for neuron in neurons}

    def _devices(self, populations: Mapping[str, Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
        owners = [label for label, one in populations.items() for _ in range(one["size"])]
        for topic in self._topics.values():
            if topic.role not in (Role.SINK, Role.SOURCE):
                continue
            neurons = json.loads(topic.about["neurons"])
            if neurons and neurons[0] < len(owners):
                yield {
                    "name": topic.about["device"],
                    "topic": topic.name,
                    "population": owners[neurons[0]],
                    "neurons": neurons,
                    "kind": topic.role,
                    "unit": topic.about.get("unit", ""),
                }


_DIRECTIONS = {Role.PUBLISHED: "in", Role.SENSOR: "out", Role.CAMERA: "out"}


_EDITS = {
    "set_weights": "weights set", "set_parameters": "parameters set", "change": "functions changed",
    "activate": "function switched", "reset": "brain reset", "lost": "change from Python",
}  # fmt: skip
"""The displayed names of calls from outside; calls to the world have their own."""


def _topic_data(topic: RecordedTopic) -> dict[str, Any]:
    return {
        "name": topic.name,
        "type": topic.type_name,
        "direction": _DIRECTIONS[Role(topic.role)],
        "unit": topic.about.get("unit") or None,
        "elements": topic.elements,
        "rate_hz": None,
    }


def _bodies(entities: list[SceneEntity], topics: list[str]) -> Iterator[dict[str, Any]]:
    """Yield the models of a scene; those without moving parts are static."""
    moves: dict[str, bool] = {}
    for entity in entities:
        model = entity.id.split("/", 1)[0]
        moves[model] = moves.get(model, False) or entity.frame_id != WORLD_FRAME
    for model, is_moving in moves.items():
        own = [name for name in topics if name.startswith(f"/{model}/")]
        fixed = {"pose": None, "colorable": None, "colored_part": None}
        yield {"name": model, "static": not is_moving, "topics": own} | fixed
