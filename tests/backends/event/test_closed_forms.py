"""Single neurons against formulas, and the search for threshold crossings against a free twin."""

from collections.abc import Callable
from math import e, exp, log

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from nrp_core.brain.devices.sinks import SpikeRecorder, SpikeRecorderPort
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS, from_milliseconds
from nrp_core.network.data import Population, Projection

Cells = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]
Run = Callable[..., Spikes]

many_brains = settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def inject(brain: Brain, times_ms: list[float], weights: list[float], receptor: str = "excitatory") -> None:
    """Let events arrive at neuron 0."""
    neurons = np.zeros(len(times_ms), np.int64)
    brain._do_inject(SynapticEvents(neurons, np.array(times_ms), np.array(weights), receptor))


@pytest.mark.parametrize("cell_type", ["IF_curr_exp", "IF_curr_alpha", "IF_curr_delta", "IF_cond_exp"])
def test_a_constant_current_makes_equal_intervals(
    cell_type: str, cells: Cells, open_brain: Open, spikes_of: Run
) -> None:
    cell = cells("a", cell_type, i_offset=1.0, tau_refrac=3.0, v_reset=-70.0)
    times_ms = spikes_of(open_brain(cell), 400.0).times_ms
    settled, first_ms = -65.0 + 20.0, 20.0 * log(20.0 / 5.0)
    interval_ms = 3.0 + 20.0 * log((settled + 70.0) / (settled + 50.0))
    expected = first_ms + interval_ms * np.arange(len(times_ms))
    assert len(times_ms) == 11
    np.testing.assert_allclose(times_ms, expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("cell_type", "values", "count", "first_ms", "last_ms"),
    [
        (
            "Izhikevich",
            {"a": 0.02, "b": 0.2, "c": -65.0, "d": 8.0, "i_offset": 0.01},
            23,
            3.45162492,
            961.74033864,
        ),
        (
            "Izhikevich",
            {"a": 0.1, "b": 0.2, "c": -65.0, "d": 2.0, "i_offset": 0.01},
            137,
            3.49440292,
            996.14488844,
        ),
        ("HH_cond_exp", {"i_offset": 0.7}, 99, 3.552293, 993.43613584),
    ],
)
def test_cells_without_a_closed_form_fire_at_the_times_of_their_equations(
    cell_type: str, values: dict[str, float], count: int, first_ms: float, last_ms: float,
    cells: Cells, open_brain: Open, spikes_of: Run,
) -> None:  # fmt: skip
    """The times are those of SciPy's DOP853 with tolerances of 1e-11."""
    initial = (
        {"v": -70.0, "u": -14.0} if cell_type == "Izhikevich" else {"v": -65.0, "m": 0.0, "h": 1.0, "n": 0.0}
    )
    times_ms = spikes_of(open_brain(cells("a", cell_type, initial=initial, **values)), 1000.0).times_ms
    assert len(times_ms) == count
    assert (times_ms[0], times_ms[-1]) == pytest.approx((first_ms, last_ms), rel=0, abs=2e-6)


def test_a_cell_whose_threshold_lies_below_its_rest_fires_at_once_and_again_and_again(
    cells: Cells, open_brain: Open, spikes_of: Run
) -> None:
    values = {"v_rest": -60.5, "v_thresh": -60.51, "v_reset": -61.6, "tau_m": 10.0, "tau_refrac": 10.0}
    cell = cells("go on", "IF_cond_alpha", initial={"v": -60.5}, **values)
    times_ms = spikes_of(open_brain(cell), 500.0).times_ms
    interval_ms = 10.0 + 10.0 * log(1.1 / 0.01)
    np.testing.assert_allclose(times_ms, interval_ms * np.arange(9), rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("cell_type", ["IF_cond_alpha", "EIF_cond_alpha_isfa_ista"])
def test_an_alpha_conductance_peaks_at_the_weight_one_time_constant_later(
    cell_type: str, cells: Cells, open_brain: Open
) -> None:
    brain = open_brain(cells("a", cell_type, tau_syn_E=3.0, tau_syn_I=7.0))
    inject(brain, [2.0], [0.002])
    inject(brain, [2.0], [0.005], "inhibitory")
    for t_ms, tau_ms, name, peak in ((5.0, 3.0, "gsyn_exc", 0.002), (9.0, 7.0, "gsyn_inh", 0.005)):
        brain.run_until(from_milliseconds(t_ms))
        assert brain.read_state(name, [0])[0] == pytest.approx(peak, rel=1e-12)
        later_ms = t_ms + tau_ms
        brain.run_until(from_milliseconds(later_ms))
        assert brain.read_state(name, [0])[0] == pytest.approx(peak * 2 * exp(-1.0), rel=1e-12)


@pytest.mark.parametrize(("tau_m", "tau_syn"), [(20.0, 2.0), (2.0, 20.0), (10.0, 10.0), (10.0, 10.001)])
def test_the_voltage_after_one_spike_is_that_of_the_formula(
    tau_m: float, tau_syn: float, cells: Cells, open_brain: Open
) -> None:
    parameters = {"tau_m": tau_m, "tau_syn_E": tau_syn, "cm": 0.5, "v_thresh": np.inf}
    brain = open_brain(cells("a", "IF_curr_exp", **parameters), cells("b", "IF_curr_alpha", **parameters))
    for neuron in (0, 1):
        events = SynapticEvents(np.array([neuron]), np.array([1.0]), np.array([0.3]), "excitatory")
        brain._do_inject(events)
    for t_ms in (1.0, 1.01, 3.0, 17.0, 150.0):
        brain.run_until(from_milliseconds(t_ms))
        steps = np.linspace(0.0, t_ms - 1.0, 20_001)
        kernel = np.exp(-(t_ms - 1.0 - steps) / tau_m) / 0.5
        currents = 0.3 * np.exp(-steps / tau_syn), 0.3 * e / tau_syn * steps * np.exp(-steps / tau_syn)
        expected = [-65.0 + simpson(kernel * current, steps) for current in currents]
        assert brain.read_state("v", [0, 1]) == pytest.approx(expected, abs=1e-9)


def simpson(values: np.ndarray, x: np.ndarray) -> float:
    """Integrate equidistant samples, odd in number."""
    weights = np.tile([2.0, 4.0], len(x) // 2 + 1)[: len(x)]
    weights[0] = weights[-1] = 1.0
    return float((weights * values).sum() * (x[1] - x[0]) / 3.0)


def test_inputs_at_one_instant_add_up_before_the_threshold_is_looked_at(
    cells: Cells, open_brain: Open, spikes_of: Run
) -> None:
    brain = open_brain(cells("a", "IF_curr_delta"))
    inject(brain, [3.0, 3.0], [20.0, 20.0])
    inject(brain, [3.0], [-30.0], "inhibitory")
    assert len(spikes_of(brain, 10.0)) == 0


def test_a_jump_over_the_threshold_fires_at_the_time_of_the_input(
    cells: Cells, open_brain: Open, spikes_of: Run
) -> None:
    brain = open_brain(cells("a", "IF_curr_delta", tau_refrac=2.0), cells("b", "Izhikevich"))
    for neuron in (0, 1):
        brain._do_inject(SynapticEvents(np.array([neuron]), np.array([3.7]), np.array([120.0])))
    spikes = spikes_of(brain, 4.0)
    assert spikes.times_ms.tolist() == [3.7, 3.7]
    assert spikes.neurons.tolist() == [0, 1]


def test_an_input_counts_from_the_end_of_the_refractory_time_on(
    cells: Cells, open_brain: Open, spikes_of: Run
) -> None:
    brain = open_brain(cells("a", "IF_curr_delta", tau_refrac=2.0))
    inject(brain, [0.1, 2.0999, 2.1], [20.0, 20.0, 20.0])
    assert spikes_of(brain, 5.0).times_ms.tolist() == [0.1, 2.1]


def test_a_hodgkin_huxley_cell_that_stays_above_its_threshold_fires_once(
    cells: Cells, open_brain: Open, spikes_of: Run
) -> None:
    brain = open_brain(cells("a", "HH_cond_exp", gbar_K=0.0, i_offset=3.0))
    spikes = spikes_of(brain, 100.0)
    assert len(spikes) == 1
    assert brain.read_state("v", [0])[0] > -20.0


tau = st.floats(0.2, 50.0)
drives = st.lists(
    st.tuples(st.integers(0, 400), st.floats(-3.0, 3.0), st.sampled_from(["excitatory", "inhibitory"])),
    min_size=1, max_size=6,
)  # fmt: skip


@given(
    cell_type=st.sampled_from(["IF_curr_exp", "IF_curr_alpha"]), tau_m=tau, tau_e=tau,
    tau_i=st.one_of(tau, st.none()), drive=drives, offset=st.floats(-0.5, 0.9),
)  # fmt: skip
@example(
    cell_type="IF_curr_alpha",
    tau_m=26.2,
    tau_e=6.1,
    tau_i=None,
    drive=[(0, -0.6, "excitatory"), (24, 2.5, "excitatory")],
    offset=0.87,
)
@example(
    cell_type="IF_curr_exp", tau_m=0.5, tau_e=5.0, tau_i=None, drive=[(0, 3.0, "inhibitory")], offset=0.5
)  # fmt: skip
@many_brains
def test_a_neuron_fires_when_its_twin_without_threshold_first_reaches_it(
    cell_type: str, tau_m: float, tau_e: float, tau_i: float | None,
    drive: list[tuple[int, float, str]], offset: float, cells: Cells, open_brain: Open,
) -> None:  # fmt: skip
    values = {"tau_m": tau_m, "tau_syn_E": tau_e, "tau_syn_I": tau_i or tau_m, "cm": 0.5}
    values["i_offset"] = offset * 15.0 * 0.5 / tau_m

    def driven(v_thresh: float) -> tuple[Brain, SpikeRecorderPort]:
        brain = open_brain(cells("a", cell_type, v_thresh=v_thresh, tau_refrac=1e4, **values))
        for tenths, size, receptor in drive:
            inject(brain, [tenths / 10.0], [size * 5.0 / tau_m], receptor)
        return brain, brain.add_sink(SpikeRecorder(), [0], name="spikes")

    neuron, recorder = driven(-50.0)
    twin, _ = driven(np.inf)
    neuron.run_until(80 * NS_PER_MS)
    fired_ms = recorder.spikes().times_ms[0] if len(recorder.spikes()) else 80.0
    for t_ms in np.arange(1, int(fired_ms / 0.1)) * 0.1:
        twin.run_until(from_milliseconds(t_ms))
        assert twin.read_state("v", [0])[0] < -50.0 + 1e-9
    if len(recorder.spikes()):
        twin.run_until(int(fired_ms * NS_PER_MS))
        assert twin.read_state("v", [0])[0] == pytest.approx(-50.0, abs=1e-3)
