"""The combinations of values that a sweep runs."""

from itertools import groupby
from math import log10
from typing import Any

import nrp_lab.evolve
import nrp_lab.sweep
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_lab.sweep.model import SweepFile, axis_of, sweep_of
from nrp_lab.sweep.plan import Plan, combinations, number_of_runs

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.section import Range, tree_of
from nrp_core.findings import InvalidExperimentError

WHOLE = st.integers(-5, 5)
AXES = st.one_of(
    st.lists(st.sampled_from([0.5, 1, True, "a", "2 mV", "b"]), min_size=1, max_size=4, unique_by=str),
    st.builds(lambda low, more: {"from": low, "to": low + more}, WHOLE, st.integers(1, 5)),
    st.builds(lambda low, steps: {"from": low / 2, "to": 9.25, "steps": steps}, WHOLE, st.integers(2, 5)),
    st.just("4..8 s"),
)
DESIGNS = st.sampled_from(["grid", {"random": 7}, {"sobol": 8}, {"latin": 5}])


def described(**keys: Any) -> SweepFile:
    return SweepFile.model_validate({"experiment": "some", **keys})


@settings(max_examples=40, deadline=None)
@given(st.dictionaries(st.sampled_from("abc"), AXES, min_size=1), DESIGNS, st.integers(1, 4))
def test_every_design_has_as_many_runs_as_it_says_and_seeds_side_by_side(
    vary: dict[str, Any], design: Any, seeds: int
) -> None:
    sampled = any(axis != "4..8 s" for axis in vary.values())
    kind = design if sampled else "grid"
    sweep = described(vary={**vary, "seed": list(range(seeds))}, design=kind)
    runs = list(combinations(sweep, 0))
    assert len(runs) == number_of_runs(sweep)
    assert runs == list(combinations(sweep, 0))
    assert [run["seed"] for run in runs] == list(range(seeds)) * (len(runs) // seeds)
    points = [str({key: run[key] for key in sweep.sampled}) for run in runs]
    assert all(len(list(same)) % seeds == 0 for _, same in groupby(points))
    for key in sweep.sampled:
        axis = axis_of(vary[key])
        if hasattr(axis, "levels") and axis.levels:
            assert {str(run[key]) for run in runs} <= {str(level) for level in axis.levels}


def test_a_grid_has_the_ends_and_equal_steps_with_their_unit() -> None:
    spans = {
        "a": {"from": "0.5 mV", "to": "2 mV", "steps": 4},
        "b": {"from": 1, "to": 1000, "steps": 4, "scale": "log"},
        "c": {"from": 3, "to": 5},
        "d": {"from": 0, "to": 10, "steps": 3},
    }
    levels = {key: list(axis_of(span).levels) for key, span in spans.items()}  # type: ignore[union-attr]
    assert levels["a"] == ["0.5 mV", "1 mV", "1.5 mV", "2 mV"]
    assert levels["b"] == [1.0, 10.0, 100.0, 1000.0]
    assert levels["c"] == [3, 4, 5]
    assert levels["d"] == [0, 5, 10]


@pytest.mark.parametrize("kind", ["random", "sobol", "latin"])
def test_a_sample_covers_its_ranges_also_on_a_logarithmic_scale(kind: str) -> None:
    vary = {"a": {"from": 0.0, "to": 1.0}, "b": {"from": 1, "to": 100, "scale": "log"}, "c": ["x", "y"]}
    runs = list(combinations(described(vary=vary, design={kind: 64}), 3))
    a, b = [run["a"] for run in runs], [log10(run["b"]) for run in runs]  # type: ignore[arg-type]
    assert all(0 <= value <= 1 for value in a)
    assert all(0 <= value <= 2 for value in b)
    assert len(set(a)) == 64
    assert sum(a) / 64 == pytest.approx(0.5, abs=0.1)
    assert sum(b) / 64 == pytest.approx(1.0, abs=0.2)
    assert 20 < sum(run["c"] == "x" for run in runs) < 44
    if kind == "latin":  # one value in each of 64 equal parts
        assert sorted(int(value * 64) for value in a) == list(range(64))  # type: ignore[operator]


def test_a_drawn_range_follows_the_seed_as_in_a_comparison() -> None:
    runs = list(combinations(described(vary={"at": "4..8 s", "seed": [1, 2]}), 0))
    expected = [Range(4, 8, "s").override("at", seed).removeprefix("at=") for seed in (1, 2)]
    assert [run["at"] for run in runs] == expected


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"vary": {"a": {"from": 0.5, "to": 2}}}, "a grid of numbers needs 'steps'"),
        ({"vary": {"a": {"from": 1, "to": 2, "step": 3}}}, "no key 'step'; did you mean 'steps'?"),
        ({"vary": {"a": {"from": "1 mV", "to": "2 V", "steps": 3}}}, "both ends need the same unit"),
        ({"vary": {"a": {"from": 2, "to": 1}}}, "must be above 'from'"),
        ({"vary": {"a": {"from": 0, "to": 1, "steps": 3, "scale": "log"}}}, "needs values above 0"),
        ({"vary": {"a": []}}, "the list of values is empty"),
        ({"vary": {"a": [1, 1]}}, "the value 1 appears twice"),
        ({"vary": {"a": 3}}, "expected a list of values"),
        ({"vary": {"seed": "1..10"}}, "seeds cannot be drawn"),
        ({"vary": {"a": [1]}, "settings": {"a": 1}}, "under both 'settings' and 'vary'"),
        ({"vary": {"a": [1]}, "design": {"sobl": 3}}, "no design 'sobl'; did you mean 'sobol'?"),
        ({"vary": {"a": [1]}, "design": {"sobol": 0}}, "a design is grid"),
        ({"vary": {"seed": [1]}, "design": {"sobol": 4}}, "no setting varies that sobol could sample"),
        ({"stop_when_failed": ["a", "b", "a"]}, "'a' is named twice"),
        ({"measure": ["distance", "distance"]}, "'distance' is named twice"),
        ({"desin": "grid"}, "a sweep has no key 'desin'; did you mean 'design'?"),
        ({"settings": {"brain": {"backend": "event"}}}, "one value with a dotted key"),
    ],
)
def test_a_mistake_in_the_description_is_named(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidExperimentError) as raised:
        sweep_of(tree_of({"experiment": "some", **keys}))
    assert message in str(raised.value.findings[0])


def test_a_sweep_without_workers_is_refused(golden: Golden) -> None:
    for call in (lambda: nrp_lab.sweep.sweep(3), lambda: nrp_lab.evolve.evolve(3, "out")):  # type: ignore[arg-type]
        with golden.raises(ExperimentError, match=r"pathlib\.Path"):
            call()
    with golden.raises(ExperimentError, match="'workers'.*'2'"):
        nrp_lab.evolve.evolve({}, "out", workers="2")  # type: ignore[arg-type]
    with golden.raises(ExperimentError, match="'workers'"):
        nrp_lab.sweep.sweep({"experiment": "braitenberg_husky", "vary": {"seed": [1]}}, workers=0)


def test_an_end_within_a_step_is_refused_before_the_first_run() -> None:
    sweep = SweepFile.model_validate({"experiment": "braitenberg_husky", "until": "30 ms"})
    with pytest.raises(InvalidExperimentError) as raised:
        Plan.of(sweep)
    assert "until: 0.03 s is not a whole number of steps of 20 ms" in str(raised.value)
