"""Who visits a run: several people, people who only watch, and programs that speak nonsense."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator

import pytest
from golden import Golden
from nrp_cockpit.session import session
from nrp_cockpit.session.controls import services_of
from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.wire.hub import Hub
from requests_of_clients import client_message, service_request
from visitors import SMALL, Cockpit, RefusedError, Visitor, cockpit
from websockets.exceptions import ConnectionClosed

from nrp_core.errors import LifecycleError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

WATCHED = {
    f"/cockpit/{name}"
    for name in (
        "bodies/models", "connections", "functions/check", "functions/complete", "layout/load", "membrane",
        "messages", "parameters", "positions", "weights",
        "designer/describe", "designer/check", "designer/fits", "designer/words",
    )
}  # fmt: skip


@pytest.fixture(scope="module")
def opened() -> Iterator[Cockpit]:
    with cockpit("world.backend=pybullet") as opened:
        yield opened


@pytest.fixture
def visitor(opened: Cockpit) -> Iterator[Visitor]:
    with opened.visit() as visitor:
        visitor.subscribe("/cockpit/experiment", "/cockpit/status")
        visitor.call("pause")
        yield visitor


def test_a_watcher_may_not_steer(opened: Cockpit, golden: Golden) -> None:
    with opened.visit(steers=False) as watcher:
        for name, number in watcher.services.items():
            if name not in WATCHED:
                with golden.raises(RefusedError):
                    watcher.answer(watcher.ask_raw(number, b"{}"))
        watcher.publish("/husky/cmd_vel", {"linear": {"x": 1}})
        assert "not control it" in watcher.until(lambda: watcher.warnings)[0]
    assert not opened.run.loop._published


def test_a_watcher_sees_what_the_others_see(opened: Cockpit, visitor: Visitor) -> None:
    with opened.visit(steers=False) as watcher:
        watcher.subscribe("/cockpit/experiment", "/cockpit/status")
        assert watcher.until(lambda: watcher.last("experiment"))["may_steer"] is False
        assert visitor.until(lambda: visitor.last("experiment"))["may_steer"] is True
        watcher.status(viewers=2)
        assert watcher.call("functions/complete")["words"]
        visitor.call("step")
        assert watcher.status(t_s=opened.run.now_s)["viewers"] == 2
    visitor.status(viewers=1)


def test_a_new_visitor_gets_the_last_reports_at_once(opened: Cockpit) -> None:
    with opened.visit() as visitor:
        reports = ("experiment", "status", "functions", "timeline", "findings")
        visitor.subscribe(*(f"/cockpit/{name}" for name in reports))
        visitor.until(lambda: all(visitor.last(name) is not None for name in reports), 5)
        assert visitor.last("experiment")["name"] == "braitenberg_husky"


def test_topics_that_are_not_remembered_are_sampled_only_for_subscribers(
    opened: Cockpit, visitor: Visitor
) -> None:
    remembered = {"spikes", "devices", "published", "/gazebo/model_states", "/husky/camera"}
    visitor.subscribe("/tf", "/scene")
    visitor.call("step", n=5)
    visitor.until(lambda: visitor.heard["/tf"] and visitor.heard["/scene"])
    assert opened.session.stream._open.keys() == {"/tf", "/scene"} | remembered
    for topic in ("/tf", "/scene"):
        visitor.unsubscribe(topic)
    visitor.call("step")
    assert opened.session.stream._open.keys() == remembered


def test_who_returns_while_nothing_goes_on_sees_the_last_image_and_none_that_is_past(
    opened: Cockpit, visitor: Visitor
) -> None:
    camera = "/husky/camera"
    images = visitor.heard[camera]
    visitor.subscribe(camera)
    visitor.call("step", n=4)
    visitor.until(lambda: images)
    last = images[-1]
    visitor.unsubscribe(camera)
    visitor.until(lambda: camera not in opened.session.hub.subscribed)
    images.clear()
    visitor.subscribe(camera)
    assert visitor.until(lambda: images)[0] == last
    visitor.unsubscribe(camera)
    visitor.until(lambda: camera not in opened.session.hub.subscribed)
    visitor.call("step", n=4)
    images.clear()
    visitor.subscribe(camera)
    visitor.call("step", n=4)
    assert all(image.t_ns > last.t_ns for image in visitor.until(lambda: images))


def test_an_earlier_time_shows_the_image_of_that_time(opened: Cockpit, visitor: Visitor) -> None:
    camera = "/husky/camera"
    images = visitor.heard[camera]
    visitor.subscribe(camera)
    visitor.call("reset", what="all")
    images.clear()
    for _ in range(20):  # a client that cannot keep up does not get each image
        visitor.call("step", n=1)
        visitor.listen(0.01)
    visitor.until(lambda: images and images[-1].t_ns > 300_000_000)
    first = {image.t_ns: image for image in images}
    for t_s in (0.3, 0.28, 0.2):
        images.clear()
        visitor.call("seek", t_s=t_s)
        visitor.until(lambda t_s=t_s: images and t_s - 0.1 < images[-1].t_ns / 1e9 <= t_s)
        visitor.listen(0.1)
        shown = images[-1]
        assert t_s - 0.1 < shown.t_ns / 1e9 <= t_s
        assert shown == first[shown.t_ns]


def test_a_client_that_has_left_is_forgotten(opened: Cockpit) -> None:
    with opened.visit() as leaving:
        leaving.subscribe("/scene")
        leaving.call("step")
    with opened.visit() as staying:
        staying.subscribe("/cockpit/status")
        staying.status(viewers=1)
        staying.call("step")
        assert opened.session.hub.subscribed == {"/cockpit/status"}
        assert "/scene" not in opened.session.stream._open


def test_the_whole_scene_is_sent_to_whoever_joins(opened: Cockpit, visitor: Visitor) -> None:
    visitor.subscribe("/scene")
    visitor.until(lambda: visitor.heard["/scene"])
    whole = len(visitor.heard["/scene"][0].payload)
    visitor.subscribe("/tf")
    visitor.call("step", n=5)
    assert len(visitor.heard["/scene"]) == 1
    with opened.visit() as other:
        other.subscribe("/scene")
        other.until(lambda: other.heard["/scene"])
        assert len(other.heard["/scene"][0].payload) == whole


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        (b"", "cut"),
        (b"\x02\x01", "cut"),
        (b"\x02\x01\x00\x00\x00\x01\x00\x00\x00\xff\xff\x00\x00", "cut"),
        (b"\x63hello", "unknown binary operation 99"),
        (client_message(99, b"{}"), "channel 99 was not advertised"),
        ("hello", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ('{"op": "subscribe"}', "a field is missing"),
        ('{"op": "subscribe", "subscriptions": 3}', "of another type"),
        (
            '{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 99999}]}',
            "no channel 99999",
        ),
        ('{"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]}', "-1 is not a valid id"),
        ('{"op": "unsubscribe", "subscriptionIds": [77]}', "there is no subscription 77"),
        ('{"op": "subscribeConnectionGraph"}', "does not support 'subscribeConnectionGraph'"),
    ],
)
def test_nonsense_is_a_warning_and_ends_nothing(opened: Cockpit, frame: str | bytes, said: str) -> None:
    with opened.visit() as visitor:
        visitor.connection.send(frame)
        assert said in visitor.until(lambda: visitor.warnings)[0]
        visitor.call("pause")


def test_an_unknown_service_and_a_wrong_request_are_refused(visitor: Visitor) -> None:
    seek = visitor.services["/cockpit/seek"]
    for service, payload, said in (
        (0, b"{}", "there is no service 0"),
        (9999, b"{}", "there is no service 9999"),
        (seek, b"{", "this is not JSON"),
        (seek, b'{"t_s": NaN}', "JSON"),
        (seek, b"[1]", "a request is a JSON object"),
    ):
        with pytest.raises(RefusedError, match=said):
            visitor.answer(visitor.ask_raw(service, payload))


def test_a_message_that_is_too_large_ends_only_its_connection(opened: Cockpit, visitor: Visitor) -> None:
    def send() -> None:
        other.connection.send(service_request(1, 1, bytes(9 << 20)))
        other.listen(10)

    with opened.visit() as other, pytest.raises(ConnectionClosed):
        send()
    visitor.call("pause")


def test_two_people_steer_one_run(opened: Cockpit, visitor: Visitor) -> None:
    steps = opened.run.loop.steps
    with opened.visit() as other:
        calls = [(each, each.ask("step")) for each in (visitor, other) for _ in range(5)]
        for each, call in calls:
            each.answer(call)
    assert opened.run.loop.steps == steps + 10


def test_a_run_goes_on_when_its_server_is_gone() -> None:
    with cockpit("world.backend=pybullet") as opened, opened.visit() as visitor:
        visitor.subscribe("/cockpit/status", "/tf", "/husky/camera")
        visitor.call("pace", factor=None)
        visitor.call("play")
        visitor.until(lambda: visitor.heard["/tf"])
        opened.server.close()
        with pytest.raises(ConnectionClosed):
            visitor.listen(10)
        steps = opened.run.loop.steps
        end_s = time.monotonic() + 60
        while opened.run.loop.steps < steps + 5:
            assert time.monotonic() < end_s
            time.sleep(0.01)
        opened.server.close()
        assert opened.session.hub.viewers == 0


def test_who_waits_for_an_answer_gets_one_when_the_session_closes(golden: Golden) -> None:
    with cockpit("world.backend=pybullet") as opened, opened.visit() as visitor:
        call = visitor.ask("seek", t_s=39.0)
        time.sleep(0.2)
        late = visitor.ask("step")
        opened.session.close()
        with golden.raises(RefusedError):
            visitor.answer(late)
        visitor.answer(call)
        assert opened.run.now_s < 39.0


def test_ctrl_c_ends_a_session_and_answers_waiting_calls(golden: Golden) -> None:
    with Run(load_experiment("braitenberg_husky", [SMALL, "world.backend=pybullet"])) as run:
        session = LiveSession(run, Hub())
        services = services_of(session)

        def interrupt() -> None:
            raise KeyboardInterrupt

        said: list[str] = []

        def wait() -> None:
            try:
                session.ask(interrupt)
            except LifecycleError as error:
                said.append(str(error))

        waiting = threading.Thread(target=wait)
        waiting.start()
        session.serve()
        waiting.join()
        assert said == ["the run is being closed"]
        with golden.raises(LifecycleError):
            services.steering["/cockpit/play"]()


def test_reports_are_json_that_a_browser_can_read(opened: Cockpit) -> None:
    hub = opened.session.hub
    hub.offer_json("/cockpit/test")
    with opened.visit() as visitor:
        visitor.subscribe("/cockpit/test")
        value = {"nan": float("nan"), "list": [float("inf"), 1.5, "x"]}
        opened.session.ask(lambda: hub.send_json("/cockpit/test", value))
        visitor.until(lambda: visitor.heard["/cockpit/test"])
        text = visitor.heard["/cockpit/test"][0].payload
    assert json.loads(text, parse_constant=pytest.fail) == {"nan": None, "list": [None, 1.5, "x"]}


def test_a_new_subscriber_receives_a_topic_while_the_run_is_paused(
    opened: Cockpit, visitor: Visitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session, "_REST_S", 60.0)
    visitor.call("pause")  # the wait after it is a long one
    visitor.subscribe("/scene")
    visitor.until(lambda: visitor.heard["/scene"], 20)
