"""The life cycle that brains and worlds share."""

import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import ArgumentError, LifecycleError, SimulationError, SnapshotError
from nrp_core.simulation import Simulation, State


class Counter(Simulation):
    """Counts nanoseconds; fails at a given time."""

    def __init__(self, identity: str = "counter") -> None:
        super().__init__(seed=1, identity=identity)
        self.count = 0
        self.fails_at: int | None = None
        self.closed = 0

    def _advance(self, t_ns: int) -> None:
        if self.fails_at is not None and t_ns >= self.fails_at:
            raise ZeroDivisionError("deep inside")
        self.count += t_ns - self.now_ns

    def _reset(self) -> None:
        self.count = 0

    def _reset_state(self) -> None:
        self.count = 0

    def _save(self) -> object:
        return self.count

    def _load(self, saved: object) -> None:
        assert isinstance(saved, int)
        self.count = saved

    def _do_close(self) -> None:
        self.closed += 1


@given(st.lists(st.integers(0, 10**6), max_size=10))
def test_how_a_run_is_split_does_not_matter(cuts: list[int]) -> None:
    simulation = Counter()
    for t_ns in sorted(cuts):
        simulation.run_until(t_ns)
        assert simulation.now_ns == t_ns == simulation.count


def test_time_never_runs_back(golden: Golden) -> None:
    simulation = Counter()
    simulation.run_until(5)
    with golden.raises(LifecycleError):
        simulation.run_until(4)
    assert simulation.state is State.READY


def test_an_engine_that_fails_is_reported_with_its_cause_and_time_and_can_only_be_reset_or_closed(
    golden: Golden,
) -> None:
    simulation = Counter()
    simulation.fails_at = 10
    simulation.run_until(5)
    with golden.raises(SimulationError, match="5e-09.*ZeroDivisionError") as failure:
        simulation.run_until(10)
    assert isinstance(failure.value.__cause__, ZeroDivisionError)
    assert failure.value.t_ns == 5
    for forbidden in (lambda: simulation.run_until(6), simulation.snapshot):
        with golden.raises(LifecycleError):
            forbidden()
    simulation.reset()
    simulation.run_until(6)
    assert simulation.count == 6


def test_reset_keeps_the_seed_unless_it_gets_another() -> None:
    simulation = Counter()
    simulation.reset()
    assert simulation.seed == 1
    simulation.reset(seed=8)
    assert (simulation.seed, simulation.now_ns) == (8, 0)


def test_a_reset_of_the_state_leaves_the_time_and_needs_a_simulation_that_has_not_failed() -> None:
    simulation = Counter()
    simulation.run_until(7)
    simulation.reset("state", seed=8)
    assert (simulation.now_ns, simulation.count, simulation.seed) == (7, 0, 8)
    simulation.fails_at = 10
    with pytest.raises(SimulationError):
        simulation.run_until(10)
    with pytest.raises(LifecycleError):
        simulation.reset("state")
    simulation.reset()
    with pytest.raises(ArgumentError):
        simulation.reset("stat")  # type: ignore[arg-type]


def test_a_snapshot_leads_back() -> None:
    simulation = Counter()
    simulation.run_until(7)
    snapshot = simulation.snapshot()
    simulation.run_until(20)
    simulation.restore(snapshot)
    assert (simulation.now_ns, simulation.count) == (7, 7)


def test_a_snapshot_of_something_else_is_refused(golden: Golden) -> None:
    with golden.raises(SnapshotError):
        Counter("one").restore(Counter("two").snapshot())


def test_closing_twice_closes_once_and_nothing_works_after_it(golden: Golden) -> None:
    with Counter() as simulation:
        simulation.run_until(1)
    simulation.close()
    assert simulation.closed == 1
    for forbidden in (lambda: simulation.run_until(2), simulation.reset, simulation.snapshot):
        with golden.raises(LifecycleError):
            forbidden()
