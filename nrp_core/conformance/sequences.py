"""Random sequences of calls: whatever is called in whatever order has one meaning.

A machine makes random calls on one simulation and keeps a log of those that matter: a reset empties it, a
restore cuts it back to where the snapshot was taken. In the end a fresh simulation gets the calls of the
log alone, its runs joined, and must be where the first one is. Hypothesis shrinks what fails.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule, run_state_machine_as_test

from nrp_core.simulation import Simulation, Snapshot

Call = tuple[str, Any]


class SequenceMachine(RuleBasedStateMachine):
    """What the machines of both sides share.

    Args:
        can_restore: whether snapshots are declared.
        step_ns: runs are multiples of it.
    """

    def __init__(self, *, can_restore: bool, step_ns: int) -> None:
        super().__init__()
        self.can_restore, self.step_ns = can_restore, step_ns
        self.log: list[Call] = []
        self.kept: tuple[Snapshot, list[Call]] | None = None
        self.simulation = self.fresh()

    @abstractmethod
    def fresh(self) -> Simulation:
        """Return a simulation at time 0 that was not used before."""

    @abstractmethod
    def apply(self, simulation: Any, name: str, value: Any) -> None:
        """Make a call of the log on a simulation."""

    @abstractmethod
    def seen(self, simulation: Any) -> object:
        """Return all that can be seen of a simulation."""

    def do(self, name: str, value: Any) -> None:
        """Make a call and keep it in the log."""
        self.apply(self.simulation, name, value)
        self.log.append((name, value))

    @rule(steps=st.integers(0, 12))
    def run(self, steps: int) -> None:
        """Advance."""
        until_ns = self.simulation.now_ns + steps * self.step_ns
        self.simulation.run_until(until_ns)
        self.log.append(("run", until_ns))

    @rule()
    def reset(self) -> None:
        """Start anew."""
        self.simulation.reset()
        self.log = []

    @precondition(lambda self: self.can_restore)
    @rule()
    def keep(self) -> None:
        """Take a snapshot."""
        self.kept = self.simulation.snapshot(), list(self.log)

    @precondition(lambda self: self.kept is not None)
    @rule()
    def restore(self) -> None:
        """Return to the snapshot."""
        assert self.kept is not None
        snapshot, log = self.kept
        self.simulation.restore(snapshot)
        self.log = list(log)

    def teardown(self) -> None:
        """Compare with a simulation that got the calls of the log alone."""
        again = self.fresh()
        with self.simulation, again:
            self.run(8)
            for index, (name, value) in enumerate(self.log):
                followed_by_run = index + 1 < len(self.log) and self.log[index + 1][0] == "run"
                if name != "run":
                    self.apply(again, name, value)
                elif not followed_by_run:
                    again.run_until(value)
            assert again.now_ns == self.simulation.now_ns
            assert self.seen(again) == self.seen(self.simulation)


def check_sequences(machine: Callable[[], SequenceMachine], *, examples: int, length: int) -> None:
    """Run a machine with sequences that are random but always the same."""
    chosen = settings(
        max_examples=examples, stateful_step_count=length, deadline=None, database=None,
        derandomize=True, suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    run_state_machine_as_test(machine, settings=chosen)  # type: ignore[arg-type]  # it takes any factory
