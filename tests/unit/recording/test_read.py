"""Reading recordings: whole ones by anybody, cut ones as far as they go."""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mcap.reader
import pytest
from golden import Golden
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.data_stream import ReadDataStream
from mcap.records import Chunk, ChunkIndex, Message
from mcap.stream_reader import breakup_chunk
from rosbags.highlevel import AnyReader

from nrp_core.errors import ExperimentError
from nrp_core.recording.layout import MCAP_NAME, RUN_NAME, SNAPSHOTS, Role, spikes_topic
from nrp_core.recording.reading.playback import Playback
from nrp_core.recording.reading.recover import recover
from nrp_core.recording.recording import Recording
from nrp_core.recording.sealing import seal


@pytest.fixture
def folder(rig: Any) -> Path:
    """A closed recording of some chunks."""
    for _ in range(10):
        rig.step()
        rig.recorder.flush()
    rig.recorder.close()
    return rig.folder  # type: ignore[no-any-return]


def raw(path: Path) -> list[tuple[str, int, bytes]]:
    return [(topic.name, message.log_time, message.data) for topic, message in Recording(path).raw()]


def by_topic(path: Path) -> dict[str, list[tuple[int, bytes]]]:
    found: dict[str, list[tuple[int, bytes]]] = {}
    for topic, t_ns, data in raw(path):
        found.setdefault(topic, []).append((t_ns, data))
    return found


def counts(path: Path) -> dict[str, int]:
    found: dict[str, int] = {}
    for topic, _ in Recording(path).raw():
        found[topic.name] = found.get(topic.name, 0) + 1
    return found


def test_raw_messages_of_a_topic_that_was_not_recorded_are_warned_of(
    folder: Path, caplog: pytest.LogCaptureFixture, golden: Golden
) -> None:
    recording = Recording(folder)
    topic = next(iter(counts(folder)))
    of_all = [message.data for found, message in recording.raw() if found.name == topic]
    assert of_all
    assert [message.data for _, message in recording.raw(iter([topic]))] == of_all
    assert not caplog.records
    assert list(recording.raw([f"{topic}s"])) == []
    assert f"no message was recorded on '{topic}s'; did you mean '{topic}'?" in caplog.text
    with golden.raises(TypeError):
        recording.raw(topic)


@pytest.mark.parametrize("misspelt", ["", "s"])
def test_a_topic_that_is_not_in_a_recording_is_reported(
    folder: Path, misspelt: str, caplog: pytest.LogCaptureFixture
) -> None:
    topic = next(iter(counts(folder)))
    read = list(Recording(folder).messages({topic + misspelt, SNAPSHOTS}))
    assert bool(read) is not bool(misspelt)
    told = f"no message was recorded on '{topic}{misspelt}'; did you mean '{topic}'?"
    assert [told in message for message in caplog.messages] == [True] * bool(misspelt)


def test_a_topic_without_a_message_is_played_back_in_silence(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A population that is silent in a run has a topic without a message."""
    topic = next(iter(counts(folder)))
    assert Playback(Recording(folder), {topic, f"{topic}s"}).until(10**12)
    assert caplog.messages == []


def test_rosbags_reads_it_without_knowing_our_classes(folder: Path) -> None:
    with AnyReader([folder / MCAP_NAME]) as reader:
        read = [(c.topic, t, reader.deserialize(data, c.msgtype)) for c, t, data in reader.messages()]
    assert len(read) == sum(counts(folder).values())
    spikes = next(message for topic, _, message in read if topic == spikes_topic("eyes"))
    assert (spikes.population, spikes.ids.tolist()) == ("eyes", [0])


def test_the_mcap_library_finds_an_index_and_every_message(folder: Path) -> None:
    with (folder / MCAP_NAME).open("rb") as file:
        reader = mcap.reader.make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        messages = list(reader.iter_messages())
    assert summary.statistics.message_count == len(messages) == sum(counts(folder).values())
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    assert [m.log_time for _, _, m in messages] == sorted(m.log_time for _, _, m in messages)


def test_each_topic_says_what_it_is(folder: Path) -> None:
    recording = Recording(folder)
    assert recording.complete
    assert [topic.name for topic in recording.with_role(Role.CAMERA)] == ["/husky/camera/compressed"]
    assert recording.topics["/husky/cmd_vel"].type_name == "geometry_msgs/msg/Twist"


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_file_cut_anywhere_gives_whole_messages_from_its_beginning(
    folder: Path, data: st.DataObject
) -> None:
    whole = (folder / MCAP_NAME).read_bytes()
    cut = folder / "cut.mcap"
    cut.write_bytes(whole[: data.draw(st.integers(0, len(whole) - 1))])
    left = raw(cut)
    assert left == raw(folder)[: len(left)]
    assert not Recording(cut).complete


def test_a_cut_loses_at_most_the_last_chunk(folder: Path) -> None:
    whole = (folder / MCAP_NAME).read_bytes()
    with (folder / MCAP_NAME).open("rb") as file:
        chunks = mcap.reader.make_reader(file).get_summary().chunk_indexes
    ends = sorted(chunk.chunk_start_offset + chunk.chunk_length for chunk in chunks)
    for chunk, end in enumerate(ends):
        cut = folder / "cut.mcap"
        cut.write_bytes(whole[: end - 1])
        assert sum(counts(cut).values()) < sum(counts(folder).values())
        assert max((t_ns for _, t_ns, _ in raw(cut)), default=-1) >= (chunk - 1) * 20_000_000


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_byte_never_shows_as_a_wrong_message(folder: Path, data: st.DataObject) -> None:
    damaged = bytearray((folder / MCAP_NAME).read_bytes())
    place = data.draw(st.integers(0, len(damaged) - 1))
    damaged[place] ^= data.draw(st.integers(1, 255))
    path = folder / "damaged.mcap"
    path.write_bytes(damaged)
    whole, read = by_topic(folder), by_topic(path)
    assert all(messages == whole[topic][: len(messages)] for topic, messages in read.items())


def test_a_recovered_file_is_read_by_anybody(folder: Path) -> None:
    whole = (folder / MCAP_NAME).read_bytes()
    cut, recovered = folder / "cut.mcap", folder / "recovered.mcap"
    cut.write_bytes(whole[: len(whole) // 2])
    outcome = recover(Recording(cut), recovered)
    assert (outcome.file, outcome.kept) == (recovered, cut)
    assert 0 < outcome.messages == sum(counts(cut).values())
    with AnyReader([recovered]) as reader:
        assert sum(1 for _ in reader.messages()) == outcome.messages
    assert Recording(recovered).topics["/gazebo/model_states"].role == Role.MODELS


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_byte_costs_a_recovery_at_most_one_chunk(folder: Path, data: st.DataObject) -> None:
    whole, known = (folder / MCAP_NAME).read_bytes(), by_topic(folder)
    with (folder / MCAP_NAME).open("rb") as file:
        chunks = mcap.reader.make_reader(file).get_summary().chunk_indexes
    largest = max(sum(1 for _ in messages_in(whole, chunk)) for chunk in chunks)
    damaged = bytearray(whole)
    damaged[data.draw(st.integers(0, len(damaged) - 1))] ^= data.draw(st.integers(1, 255))
    path, recovered = folder / "damaged.mcap", folder / "recovered.mcap"
    path.write_bytes(damaged)
    recovered.unlink(missing_ok=True)
    outcome = recover(Recording(path), recovered)
    assert sum(map(len, known.values())) - outcome.messages <= largest
    assert all(set(found) <= set(known[topic]) for topic, found in by_topic(recovered).items())


def messages_in(data: bytes, index: ChunkIndex) -> Iterator[Message]:
    start = index.chunk_start_offset + 9
    chunk = Chunk.read(ReadDataStream(io.BytesIO(data[start : start + index.chunk_length - 9])))
    return (record for record in breakup_chunk(chunk) if isinstance(record, Message))


def test_an_unfinished_file_that_holds_nothing_is_an_empty_recording(tmp_path: Path) -> None:
    path = tmp_path / MCAP_NAME
    path.touch()
    assert list(Recording(path).messages()) == []
    assert not Recording(path).complete


def test_a_folder_without_a_recording_is_an_error_with_its_name(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(ExperimentError, match=r"'recording\.mcap'") as caught:
        Recording(tmp_path)
    assert caught.value.path == tmp_path


def test_a_broken_description_of_the_run_is_an_error_with_its_name(folder: Path, golden: Golden) -> None:
    assert Recording(folder).run == {}
    (folder / RUN_NAME).write_bytes(seal({"seed": 3}))
    assert Recording(folder).run["seed"] == 3
    (folder / RUN_NAME).write_text("{")
    with golden.raises(ExperimentError, match="JSON"):
        _ = Recording(folder).run


def test_a_folder_that_lost_its_messages_can_be_checked_but_not_read(folder: Path, golden: Golden) -> None:
    (folder / RUN_NAME).write_bytes(
        seal({"seed": 3, "format": 4, "state": "ended", "files": {MCAP_NAME: "0"}})
    )
    (folder / MCAP_NAME).unlink()
    recording = Recording(folder)
    assert [(flaw.file, flaw.problem) for flaw in recording.check().flaws] == [(MCAP_NAME, "is missing")]
    for read in (recording.raw, lambda: recording.topics, lambda: recording.complete):
        with golden.raises(ExperimentError, match=r"'recording\.mcap'"):
            list(read())


def test_topics_may_come_from_an_iterator(folder: Path) -> None:
    topic = next(iter(by_topic(folder)))
    recording = Recording(folder)
    listed = [one.t_ns for one in recording.messages([topic])]
    assert listed
    assert [one.t_ns for one in recording.messages(name for name in [topic])] == listed


@pytest.mark.parametrize("topics", [3, {None}, [b"/clock"]])
def test_topics_that_are_not_names_are_refused(topics: Any, folder: Path, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        Recording(folder).messages(topics)


def test_a_misspelt_folder_gets_the_nearest_recording_beside_it_as_a_suggestion(
    folder: Path, golden: Golden
) -> None:
    with golden.raises(ExperimentError, match=f"did you mean '{folder.name}'"):
        Recording(f"{folder}s")


def test_a_recording_is_a_path(golden: Golden) -> None:
    with golden.raises(ExperimentError, match="pathlib.Path"):
        Recording(3)  # type: ignore[arg-type]
