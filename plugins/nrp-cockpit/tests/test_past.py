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
