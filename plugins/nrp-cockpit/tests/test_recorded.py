"""A recording is played, and shows at any time what was recorded of it."""

from __future__ import annotations

import json
import shutil
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel as McapChannel
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader
from nrp_cockpit.command import Kind, kind_of
from nrp_cockpit.session.arrangement import PANELS
from nrp_cockpit.session.controls import services_of_recording
from nrp_cockpit.session.recorded import CHECKING, RecordedSession
from nrp_cockpit.streaming import packing
from nrp_cockpit.streaming.recorded import WINDOW_NS
from nrp_cockpit.streaming.stored import StoredMessages
from nrp_cockpit.wire.channels import Channel, Sent
from nrp_cockpit.wire.hub import Hub
from visitors import portions

from nrp_core.errors import CapabilityError, ExperimentError, LifecycleError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.messages.cdr import Codec
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import CALLED, MCAP_NAME, RUN_NAME, RUNNING, SCENE
from nrp_core.recording.recording import Recording
from nrp_core.recording.sealing import read_sealed, seal

RED_S, LENGTH_S, STEP_S = 0.5, 2.0, 0.02
CAMERA, COMMANDS, SPIKES = "/husky/camera", "/husky/cmd_vel", "/brain/circuit/spikes"
STATES = (CAMERA, "/tf", "/gazebo/model_states", "/brain/devices/eye_sensor_transmit/green_blue_eye/rate")
SCREEN = "left_vr_screen/body/screen_glass"
MISSED = "NRP248"
"""The finding of events that are due after the end, as the other screen's here."""
Raw = list[tuple[str, int, bytes]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording of a run in which a screen turns red, images and all."""
    folder = tmp_path_factory.mktemp("recordings") / "husky"
    settings = [f"duration={LENGTH_S} s", f"events.left_red.at={RED_S} s"]
    with Run(load_experiment("braitenberg_husky", settings)) as run:
        recording = RecordingFolder(run, folder)
        run.run_until(LENGTH_S)
        recording.close("finished")
    return folder


@pytest.fixture(scope="module")
def raw(folder: Path) -> Raw:
    """Every message of it, read from beginning to end."""
    return [(topic.name, one.log_time, one.data) for topic, one in Recording(folder).raw()]


class Viewer:
    """A client without a connection: it notes what it hears."""

    dropped = 0
    may_steer = is_embedded = False

    def __init__(self, hub: Hub) -> None:
        self._hub, self.topics = hub, set[str]()
        self.heard: list[Sent] = []
        self.said: dict[str, Any] = {}
        for name in ("experiment", "status", "timeline", "findings", "functions"):
            hub.subscribe(f"/cockpit/{name}")
        hub.attach(self)  # type: ignore[arg-type]  the thread of the session is that of the server
        hub.enter(self)

    def call_soon_threadsafe(self, call: Callable[..., None], *arguments: Any) -> None:
        call(*arguments)

    def announce(self, channels: Iterable[Channel]) -> None: ...

    def tick(self, t_ns: int) -> None: ...

    def receive(self, sent: Sent) -> None:
        if sent.channel.encoding == "json":
            self.said[sent.channel.topic] = json.loads(sent.payload)
        elif sent.channel.topic in self.topics:
            self.heard.append(sent)

    def flush(self) -> None: ...

    def subscribe(self, *topics: str) -> None:
        for topic in topics:
            self.topics.add(topic)
            self._hub.subscribe(topic)

    def messages(self) -> Raw:
        """Return what it heard since the last call."""
        heard, self.heard = self.heard, []
        return [(one.channel.topic, one.t_ns, one.payload) for one in heard]


class Desk:
    """A session that serves a viewer, and what it said last.

    Args:
        session: the session.
        hub: of the session.
    """

    def __init__(self, session: RecordedSession, hub: Hub) -> None:
        self.session, self.hub, self.viewer = session, hub, Viewer(hub)

    def call(self, name: str, **fields: Any) -> Any:
        services = {**self.hub.services.steering, **self.hub.services.watching}
        return services[f"/cockpit/{name}"](**fields)

    def said(self, name: str) -> Any:
        return self.viewer.said[f"/cockpit/{name}"]

    def wait_for(self, holds: Callable[[], bool]) -> None:
        until = time.monotonic() + 120
        while not holds():
            assert time.monotonic() < until, self.said("status")
            time.sleep(0.01)

    def hears(self, *topics: str) -> None:
        """Subscribe, and wait until that was noticed."""
        self.viewer.subscribe(*topics)
        self.session.ask(lambda: self.session.stream.take(self.session.now_ns))


@contextmanager
def opened(folder: Path) -> Iterator[Desk]:
    hub = Hub()
    session = RecordedSession(folder, hub)
    hub.services = services_of_recording(session)
    serving = threading.Thread(target=session.serve)
    desk = Desk(session, hub)
    serving.start()
    try:
        desk.call("pause")  # which is answered when it has said everything once
        yield desk
    finally:
        session.close()
        serving.join()


@pytest.fixture
def desk(folder: Path) -> Iterator[Desk]:
    with opened(folder) as desk:
        yield desk


def last(raw: Raw, topic: str, t_ns: int) -> tuple[str, int, bytes]:
    return [one for one in raw if one[0] == topic and one[1] <= t_ns][-1]


def color_of(folder: Path, payload: bytes) -> tuple[float, float, float]:
    """Return the colour of the screen that turns red."""
    topic, codec = Recording(folder).topics[SCENE], Codec({})
    codec.define(topic.type_name, topic.definition)
    entities = codec.decode(payload, topic.type_name).entities
    (screen,) = (one for one in entities if one.id == SCREEN)
    color = (screen.cubes or screen.models)[0].color
    return color.r, color.g, color.b


def test_every_message_is_found_as_a_reading_from_the_beginning_finds_it(folder: Path, raw: Raw):
    messages = StoredMessages(folder / MCAP_NAME)
    found = messages.between(messages.topics, -1, messages.span_ns[1])
    assert sorted(found) == sorted(raw)
    assert messages.topics == Recording(folder).topics
    for topic in messages.topics:
        for t_ns in range(0, int(LENGTH_S * 1e9), 37_000_000):
            wanted = [one for one in raw if one[0] == topic and one[1] <= t_ns]
            assert messages.last(topic, t_ns) == (wanted[-1] if wanted else None)
    messages.close()


@pytest.mark.parametrize("times_s", [(1.5, 0.3, 1.0), (0.02, 2.0, 0.0)])
def test_a_seek_forth_or_back_shows_the_last_messages_before_that_time(
    desk: Desk, raw: Raw, times_s: tuple[float, ...]
):
    desk.hears(*STATES)
    for t_s in times_s:
        desk.viewer.messages()
        desk.call("seek", t_s=t_s)
        heard = {topic: (topic, t_ns, data) for topic, t_ns, data in desk.viewer.messages()}
        assert heard == {topic: last(raw, topic, round(t_s * 1e9)) for topic in STATES}
        assert desk.said("status")["t_s"] == t_s


def test_a_seek_unpacks_the_chunks_of_that_time_alone(folder: Path, monkeypatch: pytest.MonkeyPatch):
    messages, unpacked = StoredMessages(folder / MCAP_NAME), set[int]()
    chunks = messages._chunks
    monkeypatch.setattr(messages, "_unpacked", lambda one: unpacked.add(one) or chunks.unpacked(one))
    for topic in (CAMERA, "/tf", "/gazebo/model_states"):
        assert messages.last(topic, 1_900_000_000) is not None
    assert len(unpacked) <= 2 < len(chunks.starts)
    messages.close()


def test_spikes_and_commands_before_that_time_are_sent_with_a_seek(desk: Desk, raw: Raw):
    desk.hears(SPIKES, COMMANDS)
    desk.viewer.messages()
    desk.call("seek", t_s=1.2)
    until_ns = 1_200_000_000
    wanted = [
        one for one in raw if one[0] in (SPIKES, COMMANDS) and until_ns - WINDOW_NS < one[1] <= until_ns
    ]
    assert sorted(desk.viewer.messages()) == sorted(wanted)


def test_tables_get_all_messages_of_a_topic_whatever_the_time_is(
    desk: Desk, raw: Raw, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(packing, "MOST_BYTES", 100)  # a second at a time
    for topic in (SPIKES, COMMANDS):
        found = [(topic, t_ns, data) for t_ns, data in portions(desk.call, topic)]
        assert found == [one for one in raw if one[0] == topic]
    with pytest.raises(ExperimentError):
        desk.call("messages", topic="/brain/circuit/spike")


def test_playing_sends_every_message_once_in_order_and_as_it_was_recorded(desk: Desk, raw: Raw):
    topics = (*STATES, SPIKES, COMMANDS)
    desk.hears(*topics)
    desk.call("seek", t_s=1.0)
    desk.viewer.messages()
    desk.call("pace", factor=None)
    desk.call("play")
    desk.wait_for(lambda: desk.said("status")["state"] == "finished")
    heard = desk.viewer.messages()
    assert [one[1] for one in heard] == sorted(one[1] for one in heard)
    assert sorted(heard) == sorted(one for one in raw if one[0] in topics and one[1] > 1_000_000_000)
    with pytest.raises(LifecycleError, match="step back or reset"):
        desk.call("play")


def test_the_scene_is_that_of_the_time_also_when_it_goes_back(desk: Desk, folder: Path, raw: Raw):
    desk.hears(SCENE)
    first = last(raw, SCENE, 0)[2]
    assert [data for _, _, data in desk.viewer.messages()][-1] == first
    shown = []
    for t_s in (1.0, 0.2):
        desk.call("seek", t_s=t_s)
        shown.append(color_of(folder, desk.viewer.messages()[-1][2]))
    assert shown[0] == color_of(folder, last(raw, SCENE, 1_000_000_000)[2]) != shown[1]
    assert shown[1] == color_of(folder, first)


def test_it_steps_forth_and_back_and_runs_to_a_time(desk: Desk):
    def now() -> tuple[str, float]:
        status = desk.said("status")
        return status["state"], status["t_s"]

    desk.call("step", n=3)
    assert now() == ("paused", 3 * STEP_S)
    desk.call("step_back")
    assert now() == ("paused", 2 * STEP_S)
    desk.call("pace", factor=20)
    desk.call("run_to", t_s=1.0)
    desk.wait_for(lambda: now() == ("paused", 1.0))
    desk.call("run_to", t_s=100)
    desk.wait_for(lambda: now() == ("finished", LENGTH_S))
    desk.call("reset", what="all")
    assert now() == ("paused", 0.0)
    desk.call("step_back")
    assert now() == ("paused", 0.0)


def test_a_pause_is_answered_while_it_plays_slowly(desk: Desk):
    desk.call("pace", factor=1e-4)  # a step takes 200 seconds
    desk.call("play")
    desk.call("pause")
    status = desk.said("status")
    assert (status["state"], status["t_s"]) == ("paused", 0.0)


def test_it_says_what_was_recorded(desk: Desk, folder: Path):
    experiment, status, timeline = (desk.said(name) for name in ("experiment", "status", "timeline"))
    assert (experiment["name"], experiment["source"]) == ("braitenberg_husky", "recording")
    assert (experiment["brain"], experiment["world"], experiment["seed"]) == ("event", "mujoco", 7)
    assert (experiment["duration_s"], experiment["timestep_s"]) == (LENGTH_S, STEP_S)
    assert experiment["robots"] == ["husky"]
    assert experiment["populations"] == [
        {
            "label": "circuit",
            "size": 8,
            "first": 0,
            "cell": "IF_cond_alpha",
            "role": "circuit",
            "positions": None,
            "placed": False,
            "silent": False,
        }
    ]
    groups = {one["name"]: one["cells"] for one in experiment["groups"]}
    assert groups["actors"] == {"circuit": [[6, 8]]}
    assert all(one["own"] == {} for one in experiment["groups"])  # so few cells are drawn one by one
    devices = {one["name"]: (one["neurons"], one["kind"], one["unit"]) for one in experiment["devices"]}
    assert devices["eye_sensor_transmit/red_left_eye"] == ([0, 2], "source", "Hz")
    topics = {one["name"]: (one["type"], one["direction"]) for one in experiment["topics"]}
    assert topics[CAMERA] == ("sensor_msgs/msg/Image", "out")
    assert topics[COMMANDS] == ("geometry_msgs/msg/Twist", "in")
    bodies = {one["name"]: one for one in experiment["bodies"]}
    assert not bodies["husky"]["static"]
    assert bodies["left_vr_screen"]["static"]
    assert set(bodies["husky"]["topics"]) == {CAMERA, COMMANDS}
    assert (status["passed"], status["complete"]) == (False, True)
    assert {one["name"]: one["t_s"] for one in timeline["events"]}["left_red"] == RED_S
    assert {one["name"]: one["passed"] for one in timeline["criteria"]}["reaches_left"] is False
    functions = {one["name"]: one for one in desk.said("functions")["functions"]}
    assert functions["linear_twist"]["flow"]
    assert functions["linear_twist"]["active"]
    files = {Path(one["path"]).name: one for one in desk.said("functions")["files"]}
    assert "MapSpikeSink" in files["listing1.py"]["source"]
    assert not files["listing1.py"]["editable"]


def test_it_says_how_its_sensors_are_mounted_and_its_cells_are_connected(desk: Desk):
    experiment = desk.said("experiment")
    assert [light["kind"] for light in experiment["lights"]] == ["directional"]
    [mount] = experiment["mounts"]  # as husky.sdf has it
    assert (mount["topic"], mount["frame"]) == (CAMERA, "husky/base_link")
    assert mount["position"] == pytest.approx([-0.16, 0, 0.362])
    assert mount["view"] == {"fov_rad": 1.57, "aspect": pytest.approx(4 / 3)}
    projections = {one["label"]: one for one in experiment["projections"]}  # as brain.py has them
    assert {label: one["edges"] for label, one in projections.items()} == {
        "[2] to [7]": [[2, 7, 1.5e-4]],
        "[3] to [6]": [[3, 6, 1.5e-4]],
        "[4] to [7]": [[4, 7, 1.05e-4]],
        "[5] to [7]": [[5, 7, 1.4e-4]],
        "[0, 1] to [4, 5]": [[a, b, 1.2e-3] for b in (4, 5) for a in (0, 1)],
    }
    assert [label for label, one in projections.items() if not one["excites"]] == ["[0, 1] to [4, 5]"]


def test_a_recording_that_does_not_say_them_is_shown_without(folder: Path, tmp_path: Path):
    shutil.copytree(folder, tmp_path / "older")
    path = tmp_path / "older" / RUN_NAME
    about = read_sealed(path)
    del about["brain"]["projections"], about["world"]["mounts"], about["world"]["lights"]
    path.write_bytes(seal(about))
    with opened(tmp_path / "older") as desk:
        experiment = desk.said("experiment")
        assert experiment["projections"] == experiment["mounts"] == experiment["lights"] == []


def test_its_functions_are_read_and_not_executed(folder: Path, tmp_path: Path):
    shutil.copytree(folder, tmp_path / "changed")
    file = tmp_path / "changed" / "experiment" / "listing1.py"
    file.write_text(file.read_text() + f"\nopen({str(tmp_path / 'executed')!r}, 'w')\n")
    with opened(tmp_path / "changed") as desk:
        assert "linear_twist" in {one["name"] for one in desk.said("functions")["functions"]}
    assert not (tmp_path / "executed").exists()


def test_calls_that_would_change_a_recording_are_refused(desk: Desk):
    for name in ("publish", "push", "place", "record", "functions/apply", "functions/check", "snapshot"):
        with pytest.raises(CapabilityError, match="--from"):
            desk.call(name, any="thing")
    with pytest.raises(CapabilityError, match="cannot be changed"):
        desk.call("reset", what="robot")
    capabilities = desk.said("experiment")["capabilities"]
    assert capabilities["step_back"] is True
    assert isinstance(capabilities["place"], str)


LAYOUT = {
    "version": 1,
    "tree": {"direction": "row", "parts": [*PANELS], "sizes": [1] * len(PANELS)},
    "traces": [],
}


def test_a_layout_is_kept_beside_it(desk: Desk, folder: Path):
    assert desk.call("layout/load") == {}
    before = sorted(folder.rglob("*"))
    desk.call("layout/save", layout=LAYOUT)
    assert desk.call("layout/load") == {"layout": LAYOUT}
    assert sorted(folder.rglob("*")) == before


def test_a_whole_recording_is_found_whole(desk: Desk):
    desk.wait_for(lambda: all(one.name != CHECKING for one in threading.enumerate()))
    assert [one["code"] for one in desk.said("findings")] == [MISSED]


@pytest.fixture
def cut(folder: Path, tmp_path: Path) -> Path:
    """A recording whose file ends in the middle of its messages."""
    shutil.copytree(folder, tmp_path / "cut")
    file = tmp_path / "cut" / MCAP_NAME
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    return tmp_path / "cut"


def messages_before_the_cut(file: Path) -> Raw:
    """Return what MCAP's own reader finds until the file ends."""
    topics: dict[int, str] = {}
    found: Raw = []
    with suppress(McapError):
        for record in StreamReader(BytesIO(file.read_bytes())).records:
            if isinstance(record, McapChannel):
                topics[record.id] = record.topic
            elif isinstance(record, McapMessage):
                found.append((topics[record.channel_id], record.log_time, record.data))
    return found


@pytest.mark.parametrize("was_killed", [True, False])
def test_a_cut_recording_is_played_as_far_as_it_goes_and_says_that_it_is_cut(cut: Path, was_killed: bool):
    left = messages_before_the_cut(cut / MCAP_NAME)
    if was_killed:
        about = read_sealed(cut / RUN_NAME)
        del about["files"][MCAP_NAME]
        (cut / RUN_NAME).write_bytes(seal(about | {"state": RUNNING, "result": None}))
    with opened(cut) as desk:
        end_ns = desk.session.end_ns
        assert end_ns == max(t_ns for _, t_ns, _ in left)
        assert 0 < end_ns < LENGTH_S * 1e9
        desk.hears(CAMERA)
        with pytest.raises(ExperimentError, match="a time from 0 to"):
            desk.call("seek", t_s=LENGTH_S)
        desk.call("seek", t_s=end_ns / 1e9)
        assert desk.viewer.messages()[-1] == last(left, CAMERA, end_ns)
        assert desk.said("status")["t_s"] == end_ns / 1e9
        desk.wait_for(lambda: any(one["code"] != MISSED for one in desk.said("findings")))
        (finding,) = (one for one in desk.said("findings") if one["code"] != MISSED)
        assert finding["weight"] == "error"
        assert ("killed at" if was_killed else "messages after") in finding["summary"]
        assert desk.said("status")["complete"] is not was_killed


def test_a_damaged_chunk_is_left_out_and_the_rest_is_shown(folder: Path, tmp_path: Path, raw: Raw):
    shutil.copytree(folder, tmp_path / "damaged")
    file = tmp_path / "damaged" / MCAP_NAME
    data = bytearray(file.read_bytes())
    with file.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    chunk = chunks[len(chunks) // 2]
    data[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 0xFF
    file.write_bytes(data)
    messages = StoredMessages(file)
    found = messages.between(messages.topics, -1, messages.span_ns[1])
    assert set(found) < set(raw)
    assert {one.t_ns for one in found} >= {0, round(LENGTH_S * 1e9)}
    messages.close()


def test_a_recording_with_a_damaged_description_is_still_shown(folder: Path, tmp_path: Path, raw: Raw):
    shutil.copytree(folder, tmp_path / "damaged")
    description = tmp_path / "damaged" / RUN_NAME
    description.write_text(description.read_text().replace("husky", "rusky", 1))
    with opened(tmp_path / "damaged") as desk:
        desk.hears(CAMERA)
        desk.call("seek", t_s=1.0)
        assert desk.viewer.messages()[-1] == last(raw, CAMERA, 1_000_000_000)
        desk.wait_for(lambda: desk.said("findings") != [])
        assert any(RUN_NAME in str(one) for one in desk.said("findings"))


def test_a_folder_with_a_description_of_a_run_is_a_recording(folder: Path, tmp_path: Path):
    assert kind_of(str(folder)) is Kind.RECORDING
    assert kind_of(str(tmp_path)) is None
    assert kind_of("braitenberg_husky") is None


def test_a_damaged_change_from_outside_is_a_finding_and_the_others_are_listed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    with Run(load_experiment("braitenberg_husky", ["duration=60 ms"])) as run:
        recording = RecordingFolder(run, tmp_path / "moved")
        for x in (1.0, 2.0):
            run.run_until(x / 50)
            run.world.set_gravity((0.0, 0.0, -x))
        run.run_until(0.06)
        recording.close("finished")
    timed = StoredMessages.timed

    def damaged(self: StoredMessages, topic: str, *span_ns: int) -> list[tuple[int, bytes]]:
        found = list(timed(self, topic, *span_ns))
        return [(found[0][0], bytes(found[0][1])[:10]), *found[1:]] if topic == CALLED else found

    monkeypatch.setattr(StoredMessages, "timed", damaged)
    with opened(tmp_path / "moved") as desk:
        desk.wait_for(lambda: any(one["code"] == "NRP284" for one in desk.said("findings")))
        assert [edit["t_s"] for edit in desk.said("timeline")["edits"]] == [0.04]
