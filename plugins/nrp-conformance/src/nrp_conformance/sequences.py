"""Random sequences of calls: the state must follow from the calls, in any order.

A state machine makes random calls on one simulation and logs those that matter: a reset empties the log, a
restore truncates it to the time of the snapshot. At the end a new simulation gets only the calls of the
log, with its runs joined, and must reach the same state. Hypothesis shrinks failing sequences.
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
    """The base of the state machines for brains and worlds.

    Args:
        can_restore: whether snapshots are declared.
        step_ns: the unit of the duration of runs, ns.
    """

    def __init__(self, *, can_restore: bool, step_ns: int) -> None:
        super().__init__()
        self.can_restore, self.step_ns = can_restore, step_ns
        self.log: list[Call] = []
        self.saved: tuple[Snapshot, list[Call]] | None = None
        self.simulation = self.fresh()

    @abstractmethod
    def fresh(self) -> Simulation:
        """Return a new simulation at time 0."""

    @abstractmethod
    def apply(self, simulation: Any, name: str, value: Any) -> None:
        """Repeat a logged call on a simulation."""

    @abstractmethod
    def observed(self, simulation: Any) -> object:
        """Return the observable state of a simulation."""

    def do(self, name: str, value: Any) -> None:
        """Make a call and log it."""
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
        """Reset the simulation."""
        self.simulation.reset()
        self.log = []

    @precondition(lambda self: self.can_restore)
    @rule()
    def take_snapshot(self) -> None:
        """Take a snapshot."""
        self.saved = self.simulation.snapshot(), list(self.log)

    @precondition(lambda self: self.saved is not None)
    @rule()
    def restore(self) -> None:
        """Return to the snapshot."""
        assert self.saved is not None
        snapshot, log = self.saved
        self.simulation.restore(snapshot)
        self.log = list(log)

    def teardown(self) -> None:
        """Compare with a new simulation that gets only the logged calls."""
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
            assert self.observed(again) == self.observed(self.simulation)


def check_sequences(machine: Callable[[], SequenceMachine], *, examples: int, length: int) -> None:
    """Run a state machine with reproducible random sequences."""
    chosen = settings(
        max_examples=examples, stateful_step_count=length, deadline=None, database=None,
        derandomize=True, suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    run_state_machine_as_test(machine, settings=chosen)  # type: ignore[arg-type]  # it takes any factory
