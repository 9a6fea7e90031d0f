"""What a value depends on, decided from numbers that were made to depend on it."""

from collections.abc import Callable
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_lab.comparison.grid import ORIGINAL, Condition, GridCell
from nrp_lab.comparison.judgement import Answer, Judgement, controls_of
from nrp_lab.comparison.measuring import judge
from nrp_lab.comparison.metric import DistanceMetric, Margin, Margins, Metric, ScalarMetric

from nrp_core.errors import ExperimentError

BACKENDS = ("exact", "coarse"), ("here", "there"), (ORIGINAL,)
WIRINGS = ("exact",), ("here",), (ORIGINAL, "signs", "weights")


class Value(ScalarMetric):
    name, title, unit = "value", "Value", "m"

    def values(self, run: Any) -> dict[str, float | None]:
        return {"it": run.value}

    def resolution(self, run: Any) -> float:
        return 100.0 if run.failed else 0.0


class Met(Value):
    name, is_share, is_finding = "met", True, True
    margin = Margin(at_most=0.25)


class Apart(DistanceMetric):
    name, title, unit = "apart", "Apart", "m"

    def features(self, run: Any) -> dict[str, float]:
        return {"it": run.value}

    def distance(self, one: float, other: float) -> float:
        return abs(one - other)


def judged(
    metric: Any,
    value: Callable[[GridCell, float], float | None],
    seeds: int = 20,
    margins: Margins | None = None,
    failed: Callable[[GridCell], bool] = lambda cell: False,
    compared: tuple[tuple[str, ...], ...] = BACKENDS,
) -> Judgement:
    """Judge runs that gave ``value(cell, noise)``, the noise being that of each run."""
    conditions = [Condition(*names) for names in product(*compared)]
    cells = [condition.cell(seed) for seed in range(seeds) for condition in conditions]
    grid = SimpleNamespace(
        brains=compared[0], worlds=compared[1], variants=compared[2], timesteps=(),
        compares_variants=len(compared[2]) > 1, seeds=tuple(range(seeds)), cells=cells, conditions=conditions,
    )  # fmt: skip
    drawn = np.random.Generator(np.random.Philox(5)).normal(size=len(cells))
    runs = {
        cell: SimpleNamespace(value=value(cell, float(x)), failed=failed(cell))
        for cell, x in zip(cells, drawn, strict=True)
    }
    (found,) = judge(grid, runs, [metric()], margins or Margins())  # type: ignore[arg-type]
    return found


BY = {
    Answer.AGREES: lambda cell, x: 3.0,
    Answer.SEED: lambda cell, x: x,
    Answer.BRAIN: lambda cell, x: x + 3.0 * (cell.brain == "coarse"),
    Answer.WORLD: lambda cell, x: x + 3.0 * (cell.world == "there"),
    Answer.BOTH: lambda cell, x: x + 3.0 * (cell.world == "there") + 3.0 * (cell.brain == "coarse"),
    Answer.OPEN: lambda cell, x: x + 0.9 * (cell.brain == "coarse"),
}


@pytest.mark.parametrize("expected", list(BY))
def test_a_number_depends_only_on_its_key(expected: Answer) -> None:
    assert judged(Value, BY[expected]).answer is expected


@pytest.mark.parametrize("expected", [Answer.AGREES, Answer.SEED, Answer.BRAIN, Answer.WORLD, Answer.BOTH])
def test_a_distance_decides_like_a_value(expected: Answer) -> None:
    assert judged(Apart, BY[expected]).answer is expected


def test_the_effect_of_a_distance_is_reported_as_the_shift_that_makes_it() -> None:
    (part,) = judged(Apart, lambda cell, x: x + 3.0 * (cell.brain == "coarse"), seeds=60).parts
    brain = next(one for one in part.contrasts if one.factor == "brain")
    assert brain.effect_sd == pytest.approx(3.0, rel=0.15)


def test_an_effect_that_cancels_on_average_is_found_in_the_interaction() -> None:
    crossed = judged(Value, lambda cell, x: x + 3.0 * ((cell.brain == "coarse") == (cell.world == "there")))
    assert crossed.answer is Answer.BOTH


@pytest.mark.parametrize("metric", [Value, Apart, Met])
def test_each_control_is_compared_with_the_original_and_not_with_another(metric: type[Metric]) -> None:
    shift = {ORIGINAL: 0.0, "signs": 3.0, "weights": 0.0}
    if metric is Met:
        found = judged(metric, lambda cell, x: float(cell.wiring != "signs"), compared=WIRINGS)
    else:
        found = judged(metric, lambda cell, x: x + shift[cell.wiring], seeds=40, compared=WIRINGS)
    assert found.answer is Answer.WIRING
    assert controls_of([found]) == {"signs": "different", "weights": "equivalent"}
    same = judged(Value, lambda cell, x: 3.0, compared=WIRINGS)
    assert same.answer is Answer.STABLE


def test_too_few_seeds_decide_nothing_instead_of_no_difference() -> None:
    assert judged(Value, BY[Answer.SEED], seeds=3).answer is Answer.OPEN
    assert judged(Apart, BY[Answer.SEED], seeds=2).answer is Answer.NONE


def test_seeds_that_share_their_noise_are_compared_one_by_one() -> None:
    """A difference far below the spread is seen, and is still none that matters."""
    (part,) = judged(Value, lambda cell, x: float(np.sin(cell.seed)) + 0.1 * (cell.brain == "coarse")).parts
    brain = part.contrasts[0]
    assert brain.estimate.mean == pytest.approx(0.1)
    assert brain.p_different < 1e-6
    assert part.answer is Answer.SEED


@pytest.mark.parametrize(
    ("margin", "expected"),
    [("0.5", Answer.BRAIN), ("5", Answer.SEED), ("5 m", Answer.SEED), ("6sd", Answer.SEED)],
)
def test_a_margin_says_what_matters(margin: str, expected: Answer) -> None:
    for key in ("value", "value/it"):
        margins = Margins.parse([f"{key}={margin}"], [Value()])
        assert judged(Value, BY[Answer.BRAIN], margins=margins).answer is expected


def test_a_margin_for_nothing_is_refused(golden: Golden) -> None:
    for text, what in (
        ("valeu=1", "did you mean 'value'"),
        ("value", "METRIC=VALUE"),
        ("value=-1", "above 0"),
        ("value=1 s", r"as 0\.5 m or 2sd, not '1 s'"),
    ):
        with pytest.raises(ValueError, match=what):
            Margins.parse([text], [Value()])
    with golden.raises(ExperimentError, match="'value/at'"):
        judged(Value, BY[Answer.SEED], margins=Margins.parse(["value/at=1"], [Value()]))


def test_a_margin_of_a_part_that_no_run_will_have_is_refused_before_the_runs(golden: Golden) -> None:
    class Of(Value):
        name = "of"

        def parts(self, experiment: Any) -> list[str]:
            return ["door"]

    metrics: list[Any] = [Value(), Of()]
    experiment: Any = None
    Margins.parse(["of/door=1", "of=1", "value/only_a_run_knows=1"], metrics).require_possible(
        metrics, experiment
    )
    with golden.raises(ExperimentError, match="'of/dor'.*'of/door'"):
        Margins.parse(["of/dor=1"], metrics).require_possible(metrics, experiment)


@pytest.mark.parametrize(("seeds", "expected"), [(4, Answer.OPEN), (10, Answer.AGREES)])
def test_a_criterion_that_is_always_met_agrees_once_there_are_enough_runs(
    seeds: int, expected: Answer
) -> None:
    assert judged(Met, lambda cell, x: 1.0, seeds=seeds).answer is expected


def test_a_criterion_that_one_brain_does_not_meet_depends_on_the_brain() -> None:
    assert judged(Met, lambda cell, x: float(cell.brain == "exact"), seeds=10).answer is Answer.BRAIN


def test_a_capability_that_one_backend_lacks_does_not_decide() -> None:
    missing = judged(Value, lambda cell, x: x if cell.brain == "exact" else None)
    assert missing.answer is Answer.OPEN
    assert missing.parts[0].n_seeds == 0
    assert judged(Value, lambda cell, x: None).answer is Answer.NONE


def test_chance_is_seldom_taken_for_a_difference() -> None:
    wrong = 0
    for start in range(200):
        rng = np.random.Generator(np.random.Philox(start))
        found = judged(Value, lambda cell, x, rng=rng: float(rng.normal()), seeds=8)  # type: ignore[misc]
        wrong += found.answer.is_dependent
    assert wrong <= 16  # 10 of 200 would be the 5 % of the tests


@pytest.mark.parametrize("metric", [Value, Apart])
def test_a_run_that_failed_measures_nothing_but_that(metric: type[Metric]) -> None:
    def fails(cell: GridCell) -> bool:
        return cell.seed == 5 and cell.brain == "exact"

    def value(cell: GridCell, x: float) -> float:
        return x + 3.0 * (cell.brain == "coarse") + 1000.0 * fails(cell)

    (part,) = judged(metric, value, failed=fails).parts
    assert (part.answer, part.n_seeds, part.resolution) == (Answer.BRAIN, 19, 0.0)
    assert judged(Met, lambda cell, x: 1.0, failed=lambda cell: cell.seed == 5).parts[0].n_seeds == 20
    assert judged(metric, value, failed=lambda cell: True).answer is Answer.NONE
