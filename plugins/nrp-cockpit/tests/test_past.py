"""Snapshots that are taken on their own neither fill the memory nor hold up a run."""

from __future__ import annotations

import pytest
from golden import Golden
from nrp_cockpit.session import past
from nrp_cockpit.session.past import Past
from visitors import SMALL

from nrp_core.clock import NS_PER_S
from nrp_core.errors import CapabilityError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

UNTIL_S = 3.0


@pytest.mark.parametrize(("bytes_a_second", "taken"), [(past.BYTES_A_SECOND, 4), (4_000, 1)])
def test_large_snapshots_are_taken_more_rarely(
    bytes_a_second: int, taken: int, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.setattr(past, "BYTES_A_SECOND", bytes_a_second)
    counted = 0
    with Run(load_experiment("braitenberg_husky", [SMALL])) as run:
        snapshot = run.snapshot

        def count() -> bytes:
            nonlocal counted
            counted += 1
            return snapshot()

        monkeypatch.setattr(run, "snapshot", count)
        kept = Past(run, can_save=True)
        run.loop.hooks.after_step.append(lambda loop: kept.after_step())
        run.run_until(UNTIL_S)
        with golden.raises(CapabilityError):
            Past(run, can_save=False).way_to(NS_PER_S)
    assert counted == taken


def test_of_long_ago_few_snapshots_are_kept_and_every_time_is_still_reached(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(past, "RECENT_NS", NS_PER_S)
    monkeypatch.setattr(past, "ALONE_NS", 2 * NS_PER_S)
    with Run(load_experiment("braitenberg_husky", [SMALL])) as run:
        whole = Past(run, can_save=True)
        run.loop.hooks.after_step.append(lambda loop: whole.after_step())
        run.run_until(3.5)
        there = run.result().final_pose
        run.run_until(5.0)
        assert [each.t_ns // NS_PER_S for each in whole._moments] == [0, 2, 4, 5]
        size = len(run.snapshot())
        assert sum(len(each.data) for each in whole._moments) < size  # four, compressed, are less than one
        whole.way_to(7 * NS_PER_S // 2)()  # from the snapshot of 2 s
        assert run.now_s == 3.5
        assert run.result().final_pose == there


def test_an_abandoned_future_stays_and_can_be_taken_again() -> None:
    with Run(load_experiment("slalom_pioneer")) as run:
        whole = Past(run, can_save=True)
        run.loop.hooks.after_step.append(lambda loop: whole.after_step())
        projection = run.brain.network.projections[0].label

        def left() -> list[tuple[str, float]]:
            return [(each["id"], each["t_s"]) for each in whole.data()["snapshots"] if each["left"]]

        def state() -> tuple[object, ...]:
            return run.now_s, run.result().final_pose, run.brain.read_weights(projection).tolist()

        run.run_until(2.5)
        first = state()
        whole.way_to(NS_PER_S)()
        assert left() == []  # it can still be repeated
        whole.forget_after(NS_PER_S)
        assert [t_s for _, t_s in left()] == [2.5]
        run.run_until(2.0)
        assert state() != first
        whole.way_to(3 * NS_PER_S // 2)()
        whole.forget_after(3 * NS_PER_S // 2)
        assert [t_s for _, t_s in left()] == [2.5]  # that of 2 s is on the way there
        run.run_until(3.5)
        assert state()[0] == 3.5
        assert left() == []  # the run has repeated it

        third = state()
        whole.way_to(2 * NS_PER_S)()
        run.set_weights(projection, 0.0)
        whole.mark("weights")
        ((name, t_s),) = left()
        assert t_s == 3.5
        run.run_until(4.5)
        fourth = state()
        whole.restore(whole.named(name))
        assert state() == third
        assert whole.data()["edits"] == []
        ((name, t_s),) = left()
        whole.restore(whole.named(name))
        assert state() == fourth
        assert whole.data()["edits"] == [{"t_s": 2.0, "name": "weights"}]
        whole.forget(left()[0][0])
        assert left() == []


def test_the_oldest_abandoned_future_is_forgotten_first(monkeypatch: pytest.MonkeyPatch) -> None:
    with Run(load_experiment("slalom_pioneer")) as run:
        whole = Past(run, can_save=True)

        def left() -> list[float]:
            return [each["t_s"] for each in whole.data()["snapshots"] if each["left"]]

        for at in range(past.MOST_LEFT + 2):
            run.run_until(1.0 + at / 10)
            whole.way_to(0)()
            whole.mark(f"change {at}")
        assert left() == [round(1.2 + at / 10, 1) for at in range(past.MOST_LEFT)]
        monkeypatch.setattr(past, "MOST_BYTES", 1)
        whole.take()
        assert left() == []
