"""The difference of two recordings, against what each of them holds, and at the time that is shown."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from math import dist
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from nrp_cockpit.command import open_recording
from nrp_cockpit.session import recorded_difference
from nrp_cockpit.session.recorded import RecordedSession
from nrp_cockpit.session.session import Session
from nrp_cockpit.wire.hub import Hub

from nrp_core.errors import ExperimentError, LifecycleError
from nrp_core.recording.recording import Recording


@pytest.fixture
def session(recording: Path, other_recording: Path) -> Iterator[Session]:
    """A session that shows both, and serves in a thread of its own."""
    session = open_recording(str(recording), Hub(), str(other_recording))
    owner = threading.Thread(target=session.serve)
    owner.start()
    yield session
    session.close()
    owner.join()


def call(session: Session, name: str, **fields: Any) -> Any:
    return session.hub.services.steering[f"/cockpit/{name}"](**fields)


def data(session: Session) -> dict[str, Any]:
    assert isinstance(session, RecordedSession)
    beside = session.beside
    assert beside is not None
    return dict(session.ask(beside.data))


def positions(folder: Path) -> dict[int, Any]:
    """Return where the robot was at each time."""
    found = {}
    for one in Recording(folder).messages({"/gazebo/model_states"}):
        at = one.message.pose[one.message.name.index("husky")].position
        found[one.t_ns] = (at.x, at.y, at.z)
    return found


def test_the_robots_part_where_their_recordings_do(
    session: Session, recording: Path, other_recording: Path
) -> None:
    here, there = positions(recording), positions(other_recording)
    apart = [t_ns for t_ns in here if dist(here[t_ns], there[t_ns]) > 1e-9]
    assert 0.5e9 < apart[0] < 1e9
    call(session, "seek", t_s=2.0)
    found = data(session)
    first = {one["what"]: one["t_s"] for one in found["first"]}
    assert first["trajectory"] == apart[0] / 1e9
    assert found["distance_m"] == pytest.approx(dist(here[2 * 10**9], there[2 * 10**9]), rel=1e-12)
    assert found["labels"] == ["husky", "later"]


def test_spikes_and_events_are_those_until_the_time_that_is_shown(
    session: Session, recording: Path, other_recording: Path
) -> None:
    call(session, "seek", t_s=0.4)
    found = data(session)
    assert (found["first"], found["distance_m"]) == ([], 0.0)
    assert all(one["one"] == one["other"] for one in found["spikes"])
    call(session, "seek", t_s=0.6)
    assert {"name": "left_red", "one": 0.5, "other": None} in data(session)["events"]
    call(session, "seek", t_s=2.0)
    (circuit,) = data(session)["spikes"]
    totals = [Recording(each).run["result"]["spikes"]["circuit"] for each in (recording, other_recording)]
    assert [circuit["one"], circuit["other"]] == totals
    assert totals[0] != totals[1]


def test_only_a_neighbour_can_be_opened_and_only_one(
    session: Session, other_recording: Path, golden: Golden
) -> None:
    with golden.raises(LifecycleError):
        call(session, "compare", recording=other_recording.name)
    call(session, "part")
    with pytest.raises(ExperimentError, match="'later'"):
        call(session, "compare", recording="lather")
    with golden.raises(ExperimentError, match=r"'\.\./later'"):
        call(session, "compare", recording="../later")
    call(session, "compare", recording=other_recording.name)
    assert data(session)["labels"] == ["husky", "later"]


def test_a_criterion_has_its_outcome_from_its_decision_on() -> None:
    result = {"criteria": {"stops": {"passed": True, "decided_s": 1.5}}}
    assert [recorded_difference._passed(result, t_s) for t_s in (1.4, 1.5)] == [
        {"stops": None},
        {"stops": True},
    ]
