"""Runs of a sweep that step together are, bit for bit, those that were made one after another."""

import ast
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_lab.copies import COPIES, Attempt, Opened, may_step_together, perform_side_by_side, why_alone
from nrp_lab.sweep.executor import ATTEMPTS, executor
from nrp_lab.sweep.measuring import perform, perform_share
from nrp_lab.sweep.record import Record, Task

from nrp_core.clock import seconds
from nrp_core.experiment import Run, load_experiment, shipped
from nrp_core.utilities import work

MEASURES = ("criteria", "time_to_event", "criterion_distance")


def task(index: int, name: str, seed: int, steps: int, overrides: tuple[str, ...] = ()) -> Task:
    given = (*overrides, f"seed={seed}", "pace=max")
    return Task(f"{index}", index, name, given, MEASURES, until_s=steps / 50)


def plain(records: list[Record]) -> list[Record]:
    """Return records in the order of their tasks, without times."""
    found = [replace(record, elapsed_s=0.0, wall_time_s=0.0) for record in records]
    return sorted(found, key=lambda record: record.index)


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["slalom_pioneer", "slalom_pioneer/evolved", "slalom_pioneer/trained"]),
            st.integers(1, 5),
            st.integers(1, 12),
            st.sampled_from([(), ("world.robots.pioneer.pose=[0, 0.2, 0.0975, 0, 0, 0]",)]),
        ),
        min_size=1,
        max_size=5,
    )
)
def test_they_equal_runs_that_are_made_one_after_another(
    settings: list[tuple[str, int, int, tuple[str]]],
) -> None:
    tasks = [task(index, *one) for index, one in enumerate(settings)]
    assert plain(list(perform_share(tasks))) == plain(list(map(perform, tasks)))


def test_runs_that_stop_early_and_runs_that_cannot_begin_leave_the_others_alone() -> None:
    stopping = replace(
        task(0, "slalom_pioneer", 1, 20, ("criteria.touches_nothing.topic_stays.above=100",)),
        stop_when_failed=("touches_nothing",),
    )
    wrong = task(1, "slalom_pioneer", 1, 20, ("brain.parameters.left_to_left=often",))
    tasks = [stopping, wrong, *(task(seed, "slalom_pioneer", seed, 20) for seed in range(2, 5))]
    found = plain(list(perform_share(tasks)))
    assert [record.state for record in found] == ["finished", "invalid", *3 * ["finished"]]
    assert found[0].sim_time_s < found[2].sim_time_s == pytest.approx(0.4)
    assert found == plain(list(map(perform, tasks)))


FAILING = """
import hbp_nrp_client.tf_framework as nrp
import numpy as np
from sensor_msgs.msg import LaserScan

@nrp.MapRobotSubscriber("scan", nrp.Topic("/pioneer/scan", LaserScan))
@nrp.Robot2Neuron(triggers=["scan"], vectorized=True)
def look(t, scan):
    if t > 0.1 and np.isinf(scan.value.ranges).all(axis=1).any():
        raise ValueError("nothing in sight")
"""


@pytest.mark.parametrize("on_error", ["stop", "quarantine"])
def test_a_function_that_fails_in_one_of_them_leaves_the_others_alone(tmp_path: Path, on_error: str) -> None:
    (tmp_path / "fail.py").write_text(FAILING)
    outside = ("world.robots.pioneer.pose=[-200, 0, 0.0975, 0, 0, 0]",)
    more = (f"transfer_functions=[{tmp_path / 'fail.py'}]", f"on_error={on_error}")
    tasks = [
        task(seed, "slalom_pioneer", seed, 12, (*more, *(outside if seed == 2 else ()))) for seed in range(4)
    ]
    found = plain(list(perform_share(tasks)))
    assert [record.complete for record in found] == [True, True, False, True]
    assert found == plain(list(map(perform, tasks)))


def test_the_time_of_a_run_is_without_that_of_those_beside_it() -> None:
    tasks = [task(seed, "slalom_pioneer", seed, 25) for seed in range(8)]
    began_ns = work.now_ns()
    records = list(perform_share(tasks))
    assert all(record.elapsed_s > record.wall_time_s > 0 for record in records)
    assert sum(record.elapsed_s for record in records) <= seconds(work.now_ns() - began_ns)


@pytest.mark.heavy
def test_processes_get_shares_of_them(tmp_path: Path) -> None:
    tasks = [task(seed, "slalom_pioneer", seed, 5) for seed in range(COPIES)]
    with executor("local", tmp_path, 2) as where:
        found = plain(list(where.perform(tasks)))
    digests = [record.trajectory_digest for record in found]
    assert digests == [perform(one).trajectory_digest for one in tasks]


@pytest.mark.heavy
def test_a_run_that_kills_its_process_is_the_only_one_of_its_share_that_fails(tmp_path: Path) -> None:
    deadly = FAILING.replace('raise ValueError("nothing in sight")', '__import__("os")._exit(1)')
    (tmp_path / "fail.py").write_text(deadly)
    outside = ("world.robots.pioneer.pose=[-200, 0, 0.0975, 0, 0, 0]",)
    more = (f"transfer_functions=[{tmp_path / 'fail.py'}]",)
    tasks = [
        task(seed, "slalom_pioneer", seed, 12, (*more, *(outside if seed == 2 else ()))) for seed in range(4)
    ]
    with executor("local", tmp_path, 2) as where:
        found = plain(list(where.perform(tasks)))
    assert [record.complete for record in found] == [True, True, False, True]
    assert found[2].attempts == ATTEMPTS


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [((), True), (("brain.backend=spinnaker",), False), (("brain.model=none.py",), False)],
)
def test_only_runs_that_step_together_are_given_to_a_process_as_a_share(
    overrides: tuple[str, ...], expected: bool
) -> None:
    assert may_step_together(lambda: load_experiment("slalom_pioneer", overrides)) is expected


@pytest.mark.one_of(9)
@pytest.mark.parametrize("name", shipped())
def test_why_a_shipped_experiment_steps_alone_is_one_line_about_its_files(name: str) -> None:
    experiment = load_experiment(name)
    with Run(experiment) as run:
        reason, names = why_alone(run), [function.name for function in run.loop.functions]
    files = [path.read_bytes() for path in experiment.transfer_functions if path.suffix == ".py"]
    marked = {
        function.name
        for file in files
        for function in ast.walk(ast.parse(file))
        if isinstance(function, ast.FunctionDef)
        and any("vectorized=True" in ast.unparse(decorator) for decorator in function.decorator_list)
    }
    called = [one for one in names if one not in marked]
    expected = f"Python functions: {len(called)} calls per copy ({', '.join(called)})" if called else ""
    assert reason == expected


def test_not_more_are_open_at_once_than_gain_from_it() -> None:
    opened: list[int] = []
    closed: list[int] = []

    def attempt(number: int) -> Attempt[int]:
        with Run(load_experiment("slalom_pioneer", [f"seed={number}"])) as run:
            opened.append(len(opened) - len(closed) + 1)
            yield Opened(run, 0.02, nullcontext())
        closed.append(number)
        return number

    assert sorted(perform_side_by_side(map(attempt, range(COPIES + 2)))) == [*range(COPIES + 2)]
    assert max(opened) == COPIES
