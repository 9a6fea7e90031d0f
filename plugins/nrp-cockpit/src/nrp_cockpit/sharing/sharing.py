"""Share a recording: the file that shows it anywhere."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nrp_cockpit.session.controls import layout_of_recording, services_of_recording
from nrp_cockpit.session.recorded import RecordedSession, integrity_findings
from nrp_cockpit.session.recorded_run import FIXED
from nrp_cockpit.sharing.html import html_page
from nrp_cockpit.sharing.tracks import Track, fitted, read_tracks
from nrp_cockpit.wire.hub import Hub, to_json
from nrp_core.clock import NS_PER_S, from_seconds
from nrp_core.errors import ExperimentError
from nrp_core.findings import Code, Finding, Level
from nrp_core.messages.cdr import Codec
from nrp_core.messages.foxglove_msgs import SceneEntityDeletion, SceneUpdate

MOST_BYTES = 15_000_000
"""The usual maximum size of a file: most mail servers accept it."""
_PER_BASE64 = 3 / 4
_MARGIN = 20_000
"""Space for the elements around the data and for the findings about losses, bytes."""
_ABOUT = "nrp-recording"
_WINDOW_NS = 4 * NS_PER_S
"""What the plots show at first."""


@dataclass(frozen=True)
class SharedFile:
    """A recording in an HTML file.

    Args:
        html: the file.
        losses: the omitted data, a sentence for each topic.
    """

    html: str
    losses: tuple[str, ...]


def shared_file(folder: Path, most_bytes: int = MOST_BYTES) -> SharedFile:
    """Return an HTML file that shows a recording without a server.

    Args:
        folder: the folder of the recording.
        most_bytes: the maximum size of the file; topics are thinned until it fits, the largest first.

    Raises:
        ExperimentError: the folder is not a recording, or does not fit.
    """
    folder = folder.absolute()
    session = RecordedSession(folder, Hub())
    try:
        return _shared(folder, session, most_bytes)
    finally:
        session.messages.close()


def _shared(folder: Path, session: RecordedSession, most_bytes: int) -> SharedFile:
    title, problems = f"{folder.name} - nrp cockpit", session.run.problems
    problems += integrity_findings(session.recording)
    topics = (topic for name, topic in session.messages.topics.items() if name in session.hub.channels)
    tracks = read_tracks(session.messages, topics)
    empty = html_page(title, {_ABOUT: _about(folder, session, tracks)})
    try:
        tracks = fitted(tracks, int((most_bytes - len(empty.encode()) - _MARGIN) * _PER_BASE64))
    except ExperimentError as error:
        text = f"the recording does not fit into {most_bytes / 1e6:g} MB: {error}"
        raise ExperimentError(text, path=folder) from None
    losses = tuple(track.loss for track in tracks if track.loss is not None)
    problems += [Finding(Code.NRP284, loss, Level.NOTE) for loss in losses]
    blocks = {_ABOUT: _about(folder, session, tracks)}
    blocks |= {f"nrp-topic-{number}": track.packed for number, track in enumerate(tracks)}
    return SharedFile(html_page(title, blocks), losses)


def _about(folder: Path, session: RecordedSession, tracks: Iterable[Track]) -> bytes:
    """Return the description of the recording for the page, packed, as its ``About``; without messages."""
    run, scenes = session.run, session.stream.scenes
    entities = scenes.entities(session.now_ns) if scenes else []
    experiment = run.experiment_data(entities) | {"file": folder.name, "may_steer": True}
    timeline = run.timeline_data()
    types = {track.topic.name: track.topic.type_name for track in tracks}
    for topic in experiment["topics"]:
        topic["type"] = types.get(topic["name"], topic["type"])
    status = {
        "doing": None, "viewers": 1, "controllers": 1, "dropped": 0, "server_ms_per_step": None,
        **run.status_data(), "recorded": None,
    }  # fmt: skip
    about = {
        "begin_ns": session.now_ns,
        "end_ns": session.end_ns,
        "opens_ns": _telling_ns(session.now_ns, session.end_ns, timeline),
        "timestep_ns": session.timestep_ns,
        "topics": [_topic_data(track) for track in tracks],
        "reports": {
            "experiment": experiment,
            "status": status,
            "functions": run.functions_data(),
            "timeline": timeline,
            "findings": run.findings_data(),
        },
        "layout": layout_of_recording(session).load(),
        "services": services_of_recording(session).names,
        "refusal": FIXED,
        "clear": base64.b64encode(_clear()).decode(),
    }
    inside = to_json(f"{folder}/")[1:-1]  # its place is not needed
    return gzip.compress(to_json(about).replace(inside, b""), mtime=0)


def _telling_ns(begin_ns: int, end_ns: int, timeline: Mapping[str, Any]) -> int:
    """Return the time at which the page opens, later than the start with its empty plots and before the end.

    That is the first failure, else a second after the last event, intervention, or begin or success of a
    criterion, so that its consequences are seen; without these the middle. Plots are filled by then, if the
    run is long enough.
    """
    criteria = timeline["criteria"]
    marked = (*timeline["events"], *timeline["interventions"])
    failed = [one["to_s"] for one in criteria if one["passed"] is False]
    failed += [one["t_s"] for one in timeline["failures"]]
    changed = [one["t_s"] for one in marked if one["t_s"] is not None]
    changed += [one[key] for one in criteria if one["passed"] for key in ("from_s", "to_s")]

    def inside(times_s: Iterable[float]) -> list[int]:
        return sorted(t_ns for t_ns in map(from_seconds, times_s) if begin_ns < t_ns < end_ns)

    if failures := inside(failed):
        return failures[0]
    *_, last_ns = begin_ns, *inside(changed)
    after_ns = (last_ns + end_ns) // 2
    if last_ns > begin_ns:
        after_ns = min(last_ns + NS_PER_S, after_ns)
    return max(after_ns, min(begin_ns + _WINDOW_NS, begin_ns + (end_ns - begin_ns) * 3 // 4))


def _topic_data(track: Track) -> dict[str, Any]:
    topic = track.topic
    return {
        "topic": topic.name, "schemaName": topic.type_name, "schema": topic.definition, "shown": track.shown
    }  # fmt: skip


def _clear() -> bytes:
    """Return the message that removes all of a scene."""
    return bytes(Codec().encode(SceneUpdate([SceneEntityDeletion(type=SceneEntityDeletion.ALL)], [])))
