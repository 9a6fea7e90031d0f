"""The kit itself: its mechanics, its reference, its statistics."""

from __future__ import annotations

from collections import Counter
from math import exp, log
from types import FunctionType, SimpleNamespace

import pytest
from golden import Golden
from nrp_conformance import BrainBackendTests, WorldBackendTests, proof
from nrp_conformance.base import BackendTests
from nrp_conformance.brain.comparison import chi_square_p_value, normal_p_value, require_likely
from nrp_conformance.brain.kit import SAMPLES
from nrp_conformance.brain.reference import Arrival, simulate
from nrp_conformance.proof import SUITES
from nrp_conformance.report import LEVELS, KitReport, KitResult, Outcome, lines
from nrp_conformance.run import run_tests

from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.interface import BrainCapabilities
from nrp_core.errors import BackendError

NAME = "test_time_does_not_run_backwards"


def test_a_test_of_the_kit_cannot_be_replaced_quietly(golden: Golden):
    with golden.raises(TypeError, match="Mine.test_time_does_not_run_backwards"):
        type("Mine", (BrainBackendTests,), {NAME: lambda self: None})


@pytest.mark.parametrize("instead", [None, 3])
def test_a_test_of_the_kit_cannot_be_taken_away(instead, golden: Golden):
    with golden.raises(TypeError):
        type("Mine", (WorldBackendTests,), {"test_left_is_left": instead})


def test_an_expected_failure_needs_a_reason(golden: Golden):
    def replacement(self):
        raise AssertionError

    with golden.raises(TypeError):
        type("Mine", (BrainBackendTests,), {NAME: pytest.mark.xfail(replacement)})
    type("Mine", (BrainBackendTests,), {NAME: pytest.mark.xfail(reason="the clock is round")(replacement)})


PAIRED = "test_stdp_changes_a_weight_by_the_time_between_spikes"
FAILING = pytest.param(-8.0, marks=pytest.mark.xfail(reason="one step late"))


def _paired(self, gap):
    super(BrainBackendTests, self).test_stdp_changes_a_weight_by_the_time_between_spikes(gap)


def _own(self, gap):
    pass


def test_one_parameter_of_a_test_can_be_expected_to_fail():
    replacement = pytest.mark.parametrize("gap", [8.0, FAILING])(FunctionType(_paired.__code__, globals()))
    type("Mine", (BrainBackendTests,), {PAIRED: replacement})


@pytest.mark.parametrize(
    ("gaps", "body"),
    [
        ([FAILING], _paired),
        ([8.0, -8.0], _paired),
        ([9.0, FAILING], _paired),
        ([8.0, FAILING], _own),
        ([8.0, pytest.param(-8.0, marks=pytest.mark.xfail)], _paired),
        ([8.0, pytest.param(-8.0, marks=pytest.mark.skip(reason="late"))], _paired),
        ([pytest.param(8.0, marks=pytest.mark.skip(reason="late")), FAILING], _paired),
    ],
    ids=["fewer", "no marks", "another value", "another test", "no reason", "skipped", "one skipped"],
)
def test_the_other_parameters_stay_as_they_are(gaps, body, golden: Golden):
    replacement = pytest.mark.parametrize("gap", gaps)(FunctionType(body.__code__, globals()))
    with golden.raises(TypeError):
        type("Mine", (BrainBackendTests,), {PAIRED: replacement})


def test_tests_of_ones_own_may_be_added():
    type("Mine", (BrainBackendTests,), {"test_something_else": lambda self: None})


@pytest.mark.parametrize("suite", [suite for levels in SUITES.values() for suite in levels.values()])
def test_no_two_parts_of_a_suite_use_one_name(suite: type):
    parts = [base for base in suite.__mro__ if issubclass(base, BackendTests)]
    names = Counter(name for part in parts for name in vars(part) if not name.startswith("__"))
    assert {name for name, count in names.items() if count > 1} <= {"level", "make_backend"}


@pytest.mark.parametrize("kind", SUITES)
def test_each_level_contains_the_one_before_it(kind: str):
    contract, core, full = SUITES[kind].values()
    assert issubclass(core, contract)
    assert issubclass(full, core)


class _Odd(BackendTests):
    """Tests that come out in every way."""

    level = "accuracy"

    def test_that_passes(self):
        self.note("error_ms", 0.25)

    def test_that_fails(self):
        assert self.backend_name == "another"

    def test_that_is_skipped(self):
        pytest.skip("not declared: anything")

    @pytest.mark.xfail(reason="known")
    def test_that_is_expected_to_fail(self):
        raise AssertionError


def test_a_run_keeps_the_outcome_of_every_test():
    found = {result.test: result for result in run_tests(_Odd)}
    assert {name.removeprefix("test_that_"): str(result.outcome) for name, result in found.items()} == {
        "passes": "passed",
        "fails": "failed",
        "is_skipped": "skipped",
        "is_expected_to_fail": "expected to fail",
    }
    assert found["test_that_passes"].measured == {"error_ms": 0.25}
    assert found["test_that_is_skipped"].reason == "not declared: anything"
    assert "assert self.backend_name" in found["test_that_fails"].reason
    assert {result.level for result in found.values()} == {"accuracy"}


def _report(*results: KitResult) -> KitReport:
    return KitReport("brain", "mine", {"version": "1"}, {}, "core", {}, {}, list(results))


def test_a_report_lists_skips_failures_and_measurements():
    report = _report(
        KitResult("test_a_cell_fires[HH]", "accuracy", Outcome.PASSED, measured={"error_ms": 0.25}),
        KitResult("test_time_passes", "contract", Outcome.FAILED, "assert 1 == 2"),
        KitResult("test_snapshots", "capability", Outcome.SKIPPED, "not declared: snapshot"),
    )
    assert list(lines(report.to_dict())) == [
        "contract",
        "  ✗ time passes",
        "      assert 1 == 2",
        "capability",
        "  - snapshots  (not declared: snapshot)",
        "accuracy",
        "  ✓ a cell fires [HH]  (error_ms 0.25)",
        "brain mine does not conform: 1 passed, 1 failed, 1 skipped in 0 s",
    ]


def test_an_error_of_several_tests_is_reported_once_and_an_assertion_each_time():
    unwritten = "brain.py:20: in _build\n    raise NotImplementedError\nE   NotImplementedError: _build"
    report = _report(
        KitResult("test_a", "contract", Outcome.FAILED, unwritten),
        KitResult("test_b", "contract", Outcome.FAILED, "E   assert []\nE    +  where [] = train()"),
        KitResult("test_c", "accuracy", Outcome.FAILED, unwritten),
        KitResult("test_d", "accuracy", Outcome.FAILED, "E   assert []"),
    )
    assert list(lines(report.to_dict())) == [
        "contract",
        "  ✗ a",
        *(f"      {line}" for line in unwritten.splitlines()),
        "  ✗ b",
        "      E   assert []",
        "      E    +  where [] = train()",
        "accuracy",
        "  ✗ c  (with the same error as above)",
        "  ✗ d",
        "      E   assert []",
        "2 failed with the same error: NotImplementedError: _build",
        "brain mine does not conform: 4 failed in 0 s",
    ]


def test_a_backend_that_cannot_report_its_capabilities_is_named_with_the_place(monkeypatch):
    class Misspelt(BrainBackend):
        def capabilities(self, options):
            return BrainCapabilities(cell=frozenset())

        def open(self, network, *, seed, options):
            raise NotImplementedError

    monkeypatch.setattr(proof, "brains", lambda: SimpleNamespace(load=lambda name: Misspelt()))
    wrong = r"brain 'mine' cannot state its capabilities: TypeError: .*'cell'.* \(.*test_kit\.py:\d+\)"
    with pytest.raises(BackendError, match=wrong):
        proof.Proof("brain", "mine", {}, "core").run()


def test_a_run_without_tests_proves_nothing():
    assert not _report().conforms
    assert _report(KitResult("test_a", "contract", Outcome.PASSED)).conforms


def test_every_test_answers_one_of_the_questions():
    for levels in SUITES.values():
        for suite in levels.values():
            assert {vars(base)["level"] for base in suite.__mro__ if "level" in vars(base)} <= set(LEVELS)


def test_the_reference_fires_where_the_closed_form_does():
    sample = SAMPLES["IF_curr_exp"]
    p = sample.all_parameters
    settled = p["v_rest"] + 0.8 * p["tau_m"] / p["cm"]
    from_rest, from_reset = (
        p["tau_m"] * log((settled - p[start]) / (settled - p["v_thresh"])) for start in ("v_rest", "v_reset")
    )
    spikes = simulate(sample, until_ms=60, current_na=0.8).spikes
    expected = [from_rest + k * (p["tau_refrac"] + from_reset) for k in range(len(spikes))]
    assert len(spikes) == 4
    assert spikes == pytest.approx(expected, abs=1e-4)


def test_the_reference_answers_a_spike_as_the_closed_form_does():
    sample = SAMPLES["IF_curr_exp"]
    p = sample.all_parameters
    trace = simulate(sample, [Arrival(5.0, 0.1)], until_ms=20)
    gap = 1 / p["tau_syn_E"] - 1 / p["tau_m"]
    for t_ms in (5.0, 6.5, 9.0, 19.0):
        dt = t_ms - 5.0
        rise = 0.1 / p["cm"] * (exp(-dt / p["tau_m"]) - exp(-dt / p["tau_syn_E"])) / gap
        assert trace.voltage(t_ms) == pytest.approx(-65.0 + rise, abs=1e-7)


def test_a_cell_of_the_reference_stays_silent_without_input():
    for sample in SAMPLES.values():
        trace = simulate(sample, until_ms=30)
        assert not trace.spikes
        assert (
            trace.change(0.0, 30.0) < 1.5
        )  # Hodgkin and Huxley's own rest is a little off its initial value


def test_one_unlucky_seed_is_not_a_verdict_but_two_are():
    assert require_likely({11: 1e-9, 29: 0.4}.__getitem__) == 0.4
    with pytest.raises(AssertionError, match="1 in 1000"):
        require_likely({11: 1e-9, 29: 1e-4}.__getitem__)


def test_p_values_are_those_of_the_tables():
    assert normal_p_value(1.959964) == pytest.approx(0.05, abs=1e-6)
    assert chi_square_p_value(99.33, 100) == pytest.approx(1.0, abs=0.01)  # the median
    assert chi_square_p_value(129.56, 100) == pytest.approx(0.05, abs=0.002)  # the upper 2.5 %
