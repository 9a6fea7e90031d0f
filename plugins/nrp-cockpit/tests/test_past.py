"""Snapshots that are taken on their own neither fill the memory nor hold up a run."""

from __future__ import annotations

import pytest
from nrp_cockpit.session import past
from nrp_cockpit.session.past import Past
from visitors import SMALL

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

UNTIL_S = 3.0


@pytest.mark.parametrize(("bytes_a_second", "taken"), [(past.BYTES_A_SECOND, 4), (10_000, 1)])
def test_large_snapshots_are_taken_more_rarely(
    bytes_a_second: int, taken: int, monkeypatch: pytest.MonkeyPatch
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
    assert counted == taken
