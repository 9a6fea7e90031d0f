"""How large coefficients may be for a whole step, against the formula for the error."""

from __future__ import annotations

import numpy as np
from nrp_brain_event.grid.equations.blocks import SAFETY, bound
from nrp_brain_event.grid.equations.layout import TOLERANCE

from nrp_core.network.equations.linear import ONE

SCALE, N = 1e-3, 20_000


def test_a_step_that_is_taken_whole_has_an_error_below_the_tolerance_and_few_others_have() -> None:
    random = np.random.default_rng(5)
    change = random.uniform(0.001, 0.1, N)
    in_a = {"g": np.full(N, 1e5), ONE: np.full(N, 0.005)}  # a step of 0.1 ms over 1 nF, and over 20 ms
    in_b = {"g": np.full(N, 7e3), "current": np.full(N, 1e5), ONE: np.full(N, 3e-4)}  # 70 mV, and 60 mV
    g, current, x = random.uniform(0.0, 1e-6, N), random.uniform(0.0, 1e-9, N), random.uniform(-0.2, 0.2, N)

    found = bound(in_a, in_b, change, SCALE)
    total = found.size["g"] * g + found.size["current"] * current
    taken = total < found.least + found.slope * np.minimum(abs(x), found.reach)

    a = in_a["g"] * g + in_a[ONE]
    b = in_b["g"] * g + in_b["current"] * current + in_b[ONE]
    error = (a + change) ** 4 * (a * abs(x) + b)
    right = error < SAFETY * TOLERANCE * (SCALE + abs(x))
    assert not (taken & ~right).any()
    usual = right & (abs(x) > 0.05) & (abs(x) < 0.08)
    assert taken[usual].mean() > 0.8
    assert (~right).any()
