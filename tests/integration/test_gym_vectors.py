"""Many copies of an environment: each is, bit for bit, what it is alone with its seed."""

from collections.abc import Callable, Iterator
from contextlib import closing

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import nrp_core.gym
from nrp_core.gym import NrpEnv, make_env

assert nrp_core.gym, "importing it registers the shipped experiments"
NOISE = {"source:feelers": (0.0, 300.0, 6.0)}
SEEDS, ENDS_MS = (3, 4), (60, 100)
ACTIONS = np.random.default_rng(1).uniform(100.0, 300.0, (9, 2, 1))

Row = tuple[float, bool]


def maker(end_ms: int) -> Callable[[], NrpEnv]:
    """Return a function that makes the slalom robot with noisy feelers, for a short time."""
    short = [f"duration={end_ms} ms", "criteria=null", "transfer_functions=[]"]
    return lambda: make_env("slalom_pioneer", short, observe=["rate:feelers"], act=NOISE)


def alone(copy: int, first: int = 0) -> Iterator[Row]:
    """Yield observations and ends of a copy by itself, from an action on; it is reset after each end."""
    with closing(maker(ENDS_MS[copy])()) as env:
        env.reset(seed=SEEDS[copy])
        over = False
        for action in ACTIONS[first:, copy]:
            if over:
                (seen, _), over = env.reset(), False
            else:
                seen, _, _, over, _ = env.step({"source:feelers": action})
            yield float(seen["rate:feelers"][0]), over


def together(mode: AutoresetMode, again: int | None = None) -> list[list[Row]]:
    """Return the rows of each copy; before step ``again`` the first one alone is reset with its seed."""
    with closing(SyncVectorEnv([maker(end_ms) for end_ms in ENDS_MS], autoreset_mode=mode)) as env:
        assert env.metadata["autoreset_mode"] is mode
        env.reset(seed=list(SEEDS))
        rows: list[list[Row]] = [[], []]
        for n, action in enumerate(ACTIONS):
            if n == again:
                env.reset(seed=list(SEEDS), options={"reset_mask": np.array([True, False])})
            seen, _, _, over, _ = env.step({"source:feelers": action})
            for copy, of_copy in enumerate(rows):
                of_copy.append((float(seen["rate:feelers"][copy, 0]), bool(over[copy])))
            if mode is AutoresetMode.DISABLED and over.any():
                break
        return rows


def test_each_copy_is_what_it_is_alone_also_after_its_end() -> None:
    rows = together(AutoresetMode.NEXT_STEP)
    assert rows == [list(alone(copy)) for copy in range(2)]
    assert [[n for n, row in enumerate(of_copy) if row[1]] for of_copy in rows] == [[2, 6], [4]]
    assert rows[0] != rows[1], "their noise differs"


def test_one_copy_can_be_reset_while_the_other_continues() -> None:
    rows = together(AutoresetMode.DISABLED, again=2)
    assert rows[0][2:] == list(alone(0, first=2))[:3], "it begins again, with its seed"
    assert rows[1] == list(alone(1))[:5], "the other one goes on"


def test_shipped_experiments_are_made_by_the_number() -> None:
    with closing(gymnasium.make_vec("nrp/SlalomPioneer-v0", num_envs=2)) as env:
        assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
        seen, _ = env.reset(seed=1)
        assert seen["/pioneer/scan"].shape[0] == 2


def test_copies_that_share_a_seed_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """The comparison finds wrong copies: both have the seed of the first."""
    expected = list(alone(1))
    monkeypatch.setitem(globals(), "SEEDS", (SEEDS[0],) * 2)
    assert together(AutoresetMode.NEXT_STEP)[1] != expected
