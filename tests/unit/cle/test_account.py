"""Where the time goes, whatever happens in a step."""

from __future__ import annotations

import pytest
from golden import Golden

from nrp_core.cle import ClosedLoop
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl.testing import MockBrain, MockWorld

PERIOD = 20 * NS_PER_MS


def test_the_shares_are_all_0_before_the_first_step_and_add_up_to_1_after_it() -> None:
    loop = ClosedLoop(MockBrain({"cells": 2}), MockWorld(), period_ns=PERIOD)
    assert set(loop.account.shares().values()) == {0.0}
    loop.step()
    assert sum(loop.account.shares().values()) == pytest.approx(1)


def test_no_share_is_negative_during_the_first_step() -> None:
    loop = ClosedLoop(MockBrain({"cells": 2}), MockWorld(), period_ns=PERIOD)
    seen: list[float] = []
    loop.hooks.after_step.append(lambda loop: seen.extend(loop.account.shares().values()))
    loop.step()
    assert all(0 <= share <= 1 for share in seen)


def test_a_step_that_a_hook_breaks_off_is_counted_as_a_whole(golden: Golden) -> None:
    def fail(_loop: ClosedLoop) -> None:
        raise RuntimeError("no space left")

    loop = ClosedLoop(MockBrain({"cells": 2}), MockWorld(), period_ns=PERIOD)
    loop.hooks.after_step.append(fail)
    with golden.raises(RuntimeError):
        loop.step()
    assert loop.account.total_ns >= loop.account.both_ns > 0
