"""Whoever watches a run does not change it, however many they are and however slowly they read."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import pytest
from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.session.session import Mode
from nrp_cockpit.wire.hub import Hub
from visitors import SMALL, Cockpit, Visitor, cockpit

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.result import Result
from nrp_core.experiment.running.run import Run

UNTIL_S = 2.0
BACKENDS = [("mujoco", "event"), ("mujoco", "spinnaker"), ("pybullet", "event")]


def lived(opened: Cockpit) -> Result:
    """Play up to a time as fast as possible and return what came of it."""
    session = opened.session
    session.ask(lambda: session.set_pace(None))
    session.ask(lambda: session.run_to(UNTIL_S))
    end_s = time.monotonic() + 60
    while session.mode is Mode.RUNNING:
        assert time.monotonic() < end_s, "the run is held up"
        time.sleep(0.01)
    result: Result = session.ask(opened.run.result)
    assert result.sim_time_s == UNTIL_S
    return result


@contextmanager
def subscribed_to_everything(opened: Cockpit) -> Iterator[Visitor]:
    """Let somebody in who asks for everything and reads it."""
    with opened.visit() as visitor:
        visitor.subscribe(*visitor.channels)
        visitor.until(lambda: visitor.heard["/scene"])
        ended = threading.Event()

        def read() -> None:
            while not ended.is_set():
                visitor.listen(0.05)

        reader = threading.Thread(target=read)
        reader.start()
        try:
            yield visitor
        finally:
            ended.set()
            reader.join()


@contextmanager
def stalled(opened: Cockpit) -> Iterator[Visitor]:
    """Let somebody in who asks for everything and then never reads; little is read ahead of them."""
    with opened.visit() as visitor:
        visitor.subscribe(*visitor.channels)
        yield visitor


@contextmanager
def audience_of(number: int, opened: Cockpit) -> Iterator[list[Visitor]]:
    with ExitStack() as stack:
        yield [stack.enter_context(subscribed_to_everything(opened)) for _ in range(number)]


@pytest.fixture(scope="module")
def alone(request: pytest.FixtureRequest) -> Iterator[tuple[Cockpit, Result]]:
    """A cockpit, and what comes of the run when nobody watches."""
    world, brain = request.param
    scale = "world.options.image_scale=1"
    with cockpit(f"world.backend={world}", f"brain.backend={brain}", scale) as opened:
        yield opened, lived(opened)


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("alone", "number"),
    [(BACKENDS[0], 0), (BACKENDS[0], 1), *((pair, 5) for pair in BACKENDS)],
    indirect=["alone"],
    ids=lambda given: "-".join(given) if isinstance(given, tuple) else str(given),
)
def test_a_run_is_the_same_however_many_watch(alone: tuple[Cockpit, Result], number: int) -> None:
    opened, expected = alone
    opened.session.ask(opened.session.reset)
    with audience_of(number, opened) as visitors:
        result = lived(opened)
    for visitor in visitors:
        assert visitor.heard["/husky/camera"]
    assert result.trajectory_digest == expected.trajectory_digest
    assert result.spikes == expected.spikes
    assert sum(result.spikes.values()) > 0


@pytest.mark.parametrize("alone", BACKENDS[:1], indirect=True, ids="-".join)
def test_a_client_that_never_reads_loses_messages_and_delays_no_other_client(
    alone: tuple[Cockpit, Result],
) -> None:
    opened, expected = alone
    opened.session.ask(opened.session.reset)
    before = opened.session.hub.dropped
    with stalled(opened), opened.visit() as visitor:
        visitor.subscribe("/cockpit/status")
        result = lived(opened)
        assert visitor.status(t_s=UNTIL_S)["dropped"] > before
    assert result.trajectory_digest == expected.trajectory_digest
    assert result.spikes == expected.spikes


def test_few_snapshots_are_taken_and_no_status_is_reported_while_nobody_watches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with Run(load_experiment("braitenberg_husky", [SMALL])) as run:
        session = LiveSession(run, Hub())
        saved: list[float] = []
        snapshot = run.snapshot
        monkeypatch.setattr(run, "snapshot", lambda: (saved.append(run.now_s), snapshot())[1])
        monkeypatch.setattr(session, "_show_step", pytest.fail)
        run.run_until(5.2)
        assert saved == [5.0]  # the next after that of the beginning
        session.close()
        session.serve()  # ends at once
