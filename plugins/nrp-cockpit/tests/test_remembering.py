"""Whoever comes late gets the past of each topic, as far as it is known and fits into memory."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_cockpit.streaming.live import LiveStream
from nrp_cockpit.wire.channels import Channel, Sent
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.memory import PAST, Memory
from visitors import SMALL, Cockpit, Visitor, cockpit, portions

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.messages.cdr import Codec
from nrp_core.messages.sensor_msgs import Image

TOPICS = {name: Channel(n, name, "cdr", "", "") for n, name in enumerate(("/a", "/b"), 1)}
SPIKES, CAMERA, MODELS = "/brain/circuit/spikes", "/husky/camera", "/gazebo/model_states"


@given(st.lists(st.tuples(st.sampled_from("ab"), st.integers(0, 50), st.booleans())))
def test_a_memory_holds_of_each_topic_what_was_sent_until_time_went_back(
    events: list[tuple[str, int, bool]],
) -> None:
    memory, expected = Memory(), dict[str, list[Sent]]()
    for topic in TOPICS:
        memory.begin(topic, 0)
        expected[topic] = []
    for letter, t_ns, goes_back in events:
        if goes_back:
            memory.go_back(t_ns)
            expected = {name: [one for one in all_ if one.t_ns <= t_ns] for name, all_ in expected.items()}
        else:
            channel = TOPICS[f"/{letter}"]
            sent, before = Sent(channel, t_ns, (bytes(t_ns),)), expected[channel.topic]
            if before and t_ns < before[-1].t_ns:
                before[:] = [one for one in before if one.t_ns < t_ns]
            before.append(sent)
            memory.add(sent)
    assert {name: memory.of(name) for name in TOPICS} == {name: (0, all_) for name, all_ in expected.items()}


def test_a_full_memory_forgets_the_oldest_of_the_largest_topic_and_knows_since_when() -> None:
    memory = Memory(100_000)
    for topic in TOPICS:
        memory.begin(topic, 0)
    for t_ns in range(1, 100):
        memory.add(Sent(TOPICS["/a"], t_ns, (bytes(4_800),)))
        memory.add(Sent(TOPICS["/b"], t_ns, (b"",)))
    from_ns, messages = memory.of("/a")
    assert from_ns == messages[0].t_ns > 80
    assert messages[-1].t_ns == 99
    assert memory.of("/b")[0] == 0
    assert sum(5_000 for _ in messages) + 99 * 200 <= 100_000


def test_a_memory_of_one_message_holds_the_last() -> None:
    memory = Memory()
    memory.begin("/a", 0, most=1)
    for t_ns in range(3):
        memory.add(Sent(TOPICS["/a"], t_ns, ()))
    assert [sent.t_ns for sent in memory.of("/a")[1]] == [2]
    memory.go_back(1)
    assert memory.of("/a")[1] == []


@pytest.fixture(scope="module")
def opened() -> Iterator[Cockpit]:
    with cockpit() as opened:
        yield opened


def pasts(visitor: Visitor) -> dict[str, dict[str, Any]]:
    """Return the last announcement of each topic's past."""
    heard = (json.loads(one.payload) for one in visitor.heard[PAST])
    return {past["topic"]: past for past in heard}


def test_a_late_client_gets_what_others_were_sent_and_the_last_image(
    opened: Cockpit, visitor: Visitor
) -> None:
    visitor.subscribe(SPIKES, MODELS, CAMERA)
    visitor.call("seek", t_s=1.0)
    visitor.until(lambda: visitor.heard[SPIKES] and visitor.heard[SPIKES][-1].t_ns == 1_000_000_000)
    with opened.visit() as late:
        late.subscribe(PAST, SPIKES, MODELS, CAMERA)
        late.until(lambda: late.heard[CAMERA] and late.heard[MODELS])
        assert late.heard[SPIKES] == visitor.heard[SPIKES]
        assert late.heard[CAMERA] == visitor.heard[CAMERA][-1:]
        assert [one.t_ns for one in late.heard[MODELS]] == sorted(one.t_ns for one in late.heard[MODELS])
        assert {name: (past["from_s"], past["count"]) for name, past in pasts(late).items()} == {
            SPIKES: (0.0, len(late.heard[SPIKES])),
            MODELS: (0.0, len(late.heard[MODELS])),
            CAMERA: (pytest.approx(1.0, abs=0.04), 1),
        }


def test_tables_get_all_that_is_remembered_of_a_topic(opened: Cockpit, visitor: Visitor) -> None:
    visitor.subscribe(SPIKES)
    visitor.call("seek", t_s=1.5)
    visitor.until(lambda: visitor.heard[SPIKES] and visitor.heard[SPIKES][-1].t_ns == 1_500_000_000)
    with opened.visit() as late:
        assert portions(late.call, SPIKES) == visitor.heard[SPIKES]
        assert portions(late.call, "/nobody/subscribed") == []


def test_whoever_subscribes_just_before_a_jump_gets_its_first_step(opened: Cockpit) -> None:
    with opened.visit() as visitor:
        visitor.call("reset", what="all")
        visitor.subscribe("/husky/cmd_vel")
        visitor.call("seek", t_s=0.1)
        visitor.until(lambda: len(visitor.heard["/husky/cmd_vel"]) == 5)


def test_a_client_that_does_not_ask_for_the_past_gets_only_the_last_message(
    opened: Cockpit, visitor: Visitor
) -> None:
    visitor.call("seek", t_s=0.5)
    with opened.visit() as late:
        late.subscribe(SPIKES, MODELS)
        late.until(lambda: late.heard[MODELS])
        late.listen(0.2)
        assert [one.t_ns for one in late.heard[MODELS]] == [500_000_000]
        assert late.heard[SPIKES] == []


def test_a_jump_back_undoes_what_came_later(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("seek", t_s=1.5)
    visitor.call("seek", t_s=0.5)
    with opened.visit() as late:
        late.subscribe(PAST, SPIKES, CAMERA)
        late.until(lambda: late.heard[SPIKES] and late.heard[CAMERA])
        late.listen(0.2)
        assert max(one.t_ns for one in late.heard[SPIKES]) == 500_000_000
        assert len({one.t_ns for one in late.heard[SPIKES]}) == len(late.heard[SPIKES]) > 20
        assert late.heard[CAMERA][-1].t_ns > 400_000_000


def test_what_was_published_before_the_first_step_is_forgotten_at_the_start(
    opened: Cockpit, visitor: Visitor
) -> None:
    topic = "/left_vr_screen/body/screen_glass/color"
    visitor.subscribe(topic)
    visitor.call("reset", what="all")
    visitor.call("publish", topic=topic, value="red")
    visitor.call("step", n=1)
    (red,) = {one.payload for one in portions(visitor.call, topic)[-1:]}
    visitor.call("reset", what="all")
    assert red not in {one.payload for one in portions(visitor.call, topic)}


def test_an_abandoned_past_is_unknown(opened: Cockpit, visitor: Visitor) -> None:
    visitor.subscribe(PAST, SPIKES)
    visitor.call("seek", t_s=1.0)
    taken = visitor.call("snapshot")
    visitor.call("reset", what="all")
    visitor.call("publish", topic="/left_vr_screen/body/screen_glass/color", value="red")
    visitor.call("step", n=5)
    visitor.call("restore", id=taken["id"])
    visitor.until(lambda: pasts(visitor)[SPIKES]["new"] and pasts(visitor)[SPIKES]["from_s"] == 1.0)
    assert pasts(visitor)[SPIKES]["count"] == 0
    visitor.call("forget", id=taken["id"])


def test_a_topic_is_remembered_from_when_somebody_first_asked_for_it(
    opened: Cockpit, visitor: Visitor
) -> None:
    visitor.subscribe(PAST)
    visitor.call("seek", t_s=0.5)
    visitor.subscribe("/husky/odom")
    visitor.until(lambda: "/husky/odom" in pasts(visitor))
    assert pasts(visitor)["/husky/odom"]["from_s"] == 0.5
    visitor.unsubscribe("/husky/odom")
    visitor.call("seek", t_s=1.0)
    visitor.subscribe("/husky/odom")
    heard = visitor.heard["/husky/odom"]
    visitor.until(lambda: heard and heard[-1].t_ns == 1_000_000_000)
    assert [one.t_ns for one in heard] == sorted({one.t_ns for one in heard})
    assert heard[0].t_ns < 600_000_000


def test_a_client_that_comes_late_gets_what_one_got_that_was_there_from_the_beginning() -> None:
    topics = SPIKES, MODELS, "/husky/cmd_vel", CAMERA
    with cockpit() as watched, cockpit() as unwatched:
        with watched.visit() as early:
            early.subscribe(PAST, *topics)
            early.call("seek", t_s=1.0)
            expected = {topic: portions(early.call, topic) for topic in topics}
        session = unwatched.session
        session.ask(lambda: session.seek(1.0))
        with unwatched.visit() as late:
            late.subscribe(PAST, *topics)
            late.until(lambda: late.heard[CAMERA] and set(topics) <= pasts(late).keys())
            assert {topic: portions(late.call, topic) for topic in topics} == expected
            assert {pasts(late)[topic]["from_s"] for topic in (SPIKES, MODELS, "/husky/cmd_vel")} == {0.0}
    assert all(expected.values())


def test_a_run_is_remembered_after_its_last_client_has_left(opened: Cockpit) -> None:
    session = opened.session
    with opened.visit() as visitor:
        visitor.call("reset", what="all")
        visitor.call("step", n=2)
    session.ask(lambda: session.step(3))
    with opened.visit() as late:
        times_ns = {one.t_ns for one in portions(late.call, MODELS)}
        assert times_ns == {0, 40_000_000, 80_000_000, 100_000_000}


def test_images_are_encoded_when_somebody_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    encoded: list[Any] = []
    encode = Codec.encode

    def note(codec: Codec, message: Any) -> memoryview:
        encoded.append(message)
        return encode(codec, message)

    monkeypatch.setattr(Codec, "encode", note)
    with cockpit() as opened:
        session = opened.session
        session.ask(lambda: session.step(10))
        assert encoded
        assert not any(isinstance(each, Image) for each in encoded)
        with opened.visit() as late:
            late.subscribe(PAST, CAMERA)
            late.until(lambda: late.heard[CAMERA])
        (image,) = (each for each in encoded if isinstance(each, Image))
        assert late.heard[CAMERA][0].payload == bytes(encode(Codec(), image))


def test_a_run_that_nobody_watches_keeps_within_a_small_memory_what_was_last() -> None:
    hub, most_bytes = Hub(), 20_000
    hub.memory = Memory(most_bytes)
    with Run(load_experiment("braitenberg_husky", [SMALL])) as run:
        stream = LiveStream(run, hub)
        run.loop.hooks.after_step.append(lambda _: stream.take())
        stream.take()
        run.run_until(2.0)
        pasts = {topic: hub.past_of(topic) for topic in stream.topics}
        stream.close()
    kept = [sent for _, messages in pasts.values() for sent in messages]
    assert most_bytes / 2 < sum(sent.size + 200 for sent in kept) <= most_bytes
    from_ns, spikes = pasts[SPIKES]
    assert 0 < from_ns == spikes[0].t_ns
    assert pasts["/husky/cmd_vel"][1][-1].t_ns >= 1_960_000_000
