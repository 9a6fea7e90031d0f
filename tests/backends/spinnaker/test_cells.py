"""Cells with PyNN's meaning, and the accuracy of what is not the machine's own."""

from collections.abc import Callable
from math import e, exp

import numpy as np
import pytest
from golden import Golden

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Population, Projection

MS = 1_000_000
BRAITENBERG = {
    "v_rest": -60.5, "v_reset": -60.5, "v_thresh": 0.0, "cm": 0.025, "tau_m": 10.0, "tau_refrac": 10.0,
    "tau_syn_E": 2.5, "tau_syn_I": 2.5, "e_rev_E": 0.0, "e_rev_I": -75.0,
}  # fmt: skip
Maker = Callable[..., Population]
Open = Callable[..., Brain]


def inject(brain: Brain, times_ms: list[float], weight: float, receptor: str = "excitatory") -> None:
    n = len(times_ms)
    brain._do_inject(SynapticEvents(np.zeros(n, np.int64), np.array(times_ms), np.full(n, weight), receptor))


def trace(brain: Brain, variable: str, until_ms: float) -> np.ndarray:
    """Return a variable of cell 0 at every grid point from 0 on."""
    step_ns = brain.capabilities.resolution_ns
    values = []
    for t_ns in range(0, round(until_ms * MS) + 1, step_ns):
        brain.run_until(t_ns)
        values.append(brain.read_state(variable, [0])[0])
    return np.array(values)


def test_a_weight_in_mv_lifts_a_delta_cell_by_as_much(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_delta", cm=0.3, tau_m=13.0))
    inject(brain, [2.0], 5.0)
    v = trace(brain, "v", 5)
    assert v[:3].tolist() == [-65.0] * 3
    assert v[3] == pytest.approx(-60.0, abs=2e-3)
    inject(brain, [10.0], -5.0, "inhibitory")
    assert _run(brain, 11) == pytest.approx(-65 + 5 * exp(-8 / 13) - 5, abs=0.02)


def _run(brain: Brain, until_ms: float) -> float:
    brain.run_until(round(until_ms * MS))
    return float(brain.read_state("v", [0])[0])


def test_a_network_weight_in_mv_lifts_a_delta_cell_by_as_much(
    cells: Maker, spike_source: Maker, connect: Callable[..., Projection], open_brain: Open
) -> None:
    pre, post = spike_source("s", [2.0]), cells("n", "IF_curr_delta", 2, cm=0.3, tau_m=13.0)
    brain = open_brain(pre, post, connect("s", "n", [5.0, 2.5], 1.0, pairs=[(0, 0), (0, 1)]))
    brain.run_until(4 * MS)
    assert brain.read_state("v", [1, 2]).tolist() == pytest.approx([-60.0, -62.5], abs=5e-3)


def test_the_released_semantics_take_a_delta_weight_as_a_current(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_delta"), semantics="released")
    inject(brain, [2.0], 8.0)
    assert _run(brain, 3) == pytest.approx(-65 + 8 * 20 * (1 - exp(-1 / 20)), abs=0.01)


def test_an_alpha_current_peaks_at_its_weight(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_alpha", tau_syn_E=3.0, v_thresh=1000.0), timestep="0.1 ms")
    inject(brain, [1.0], 0.8)
    current = trace(brain, "isyn_exc", 20)
    assert current.max() == pytest.approx(0.8, rel=0.005)
    assert np.argmax(current) == pytest.approx(40, abs=2)


def test_the_released_alpha_synapse_of_default_length_has_no_effect(cells: Maker, open_brain: Open) -> None:
    for semantics, lifted in (("released", False), ("pynn", True)):
        brain = open_brain(cells("n", "IF_curr_alpha", tau_syn_E=0.5), semantics=semantics)
        inject(brain, [1.0], 5.0)
        assert (_run(brain, 8) > -65.0) == lifted


def test_an_izhikevich_weight_is_a_jump_in_mv_and_its_current_in_na(cells: Maker, open_brain: Open) -> None:
    quiet, jumped = (open_brain(cells("n", "Izhikevich"), timestep="0.1 ms") for _ in range(2))
    inject(jumped, [1.0], 3.0)
    assert _run(jumped, 1.1) - _run(quiet, 1.1) == pytest.approx(3.0, abs=0.2)
    driven = open_brain(cells("n", "Izhikevich", d=8.0, i_offset=0.01))
    assert len(_spikes(driven, 300)) == 8
    released = open_brain(cells("n", "Izhikevich", d=8.0, i_offset=10.0), semantics="released")
    assert _spikes(released, 300) == _spikes(
        open_brain(cells("n", "IZK_curr_exp", d=8.0, i_offset=10.0)), 300
    )


def _spikes(brain: Brain, until_ms: float) -> list[float]:
    recorder = brain.add_sink(SpikeRecorder(), [0], name="cell")
    brain.run_until(round(until_ms * MS))
    return recorder.spikes().times_ms.tolist()


def test_a_huge_jump_makes_an_izhikevich_cell_fire_and_not_wrap(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "Izhikevich"))
    inject(brain, [1.0], 20000.0)
    assert _spikes(brain, 3) == [2.0]
    assert -100 < _run(brain, 4) < 30


# -- IF_cond_alpha, an extension


def test_an_alpha_conductance_peaks_at_its_weight_and_accumulates(cells: Maker, open_brain: Open) -> None:
    starts = [2.0, 2.0, 4.5]
    one, many = (open_brain(cells("n", "IF_cond_alpha", **BRAITENBERG), timestep="0.1 ms") for _ in range(2))
    inject(one, [1.0], 1.5e-4)
    inject(many, starts, 1.2e-3, "inhibitory")
    assert trace(one, "gsyn_exc", 12).max() == pytest.approx(1.5e-4, rel=0.02)
    # between two ticks the value is the mean over the step to come, close to the one in its middle
    expected = alpha(np.arange(0.05, 12.1, 0.1), starts, 1.2e-3)
    conductance = trace(many, "gsyn_inh", 12)
    assert np.abs(conductance - expected)[conductance > 0].max() < 0.03 * 2.4e-3


def alpha(t: np.ndarray | float, starts: list[float], weight: float, tau: float = 2.5) -> np.ndarray:
    since = np.maximum(np.subtract.outer(np.asarray(t), starts), 0.0)
    return (weight * e * since / tau * np.exp(-since / tau)).sum(axis=-1)


def float_reference(excitatory: list[float], inhibitory: list[float], until_ms: float) -> np.ndarray:
    """Integrate the membrane with the classical Runge-Kutta method; return V at every 0.1 ms."""
    h = 0.05
    p = BRAITENBERG

    def slope(t: float, v: float) -> float:
        current = alpha(t, excitatory, 1.5e-4) * (p["e_rev_E"] - v)
        current += alpha(t, inhibitory, 1.2e-3) * (p["e_rev_I"] - v)
        return (p["v_rest"] - v) / p["tau_m"] + float(current) / p["cm"]

    values, v = [p["v_rest"]], p["v_rest"]
    for k in range(round(until_ms / h)):
        t = k * h
        a = slope(t, v)
        b = slope(t + h / 2, v + h / 2 * a)
        c = slope(t + h / 2, v + h / 2 * b)
        v += h / 6 * (a + 2 * b + 2 * c + slope(t + h, v + h * c))
        values.append(v)
    return np.array(values)[:: round(0.1 / h)]


@pytest.mark.parametrize(("timestep", "bound_mv"), [("1 ms", 0.4), ("0.1 ms", 0.06)])
def test_an_alpha_conductance_cell_follows_a_float_reference(
    timestep: str, bound_mv: float, cells: Maker, open_brain: Open
) -> None:
    excitatory, inhibitory = [2.0, 5.0, 6.0, 7.0, 7.0, 20.0, 30.0, 31.0], [10.0, 33.0]
    brain = open_brain(cells("n", "IF_cond_alpha", **BRAITENBERG), timestep=timestep)
    inject(brain, excitatory, 1.5e-4)
    inject(brain, inhibitory, 1.2e-3, "inhibitory")
    v = trace(brain, "v", 50)
    reference = float_reference(excitatory, inhibitory, 50)[:: round(500 / (len(v) - 1))]
    assert np.ptp(reference) > 5
    assert np.abs(v - reference).max() < bound_mv


# -- adaptive exponential and Hodgkin-Huxley cells, extensions


def adaptive_reference(p: dict[str, float], until_ms: float, h: float = 0.001) -> list[float]:
    v, w, refractory, spikes = p["v_rest"], 0.0, 0.0, []
    g = p["cm"] / p["tau_m"]
    for k in range(round(until_ms / h)):
        w += h * (p["a"] * 1e-3 * (v - p["v_rest"]) - w) / p["tau_w"]
        if refractory > 0:
            refractory -= h
            continue
        spike = g * p["delta_T"] * exp(min((v - p["v_thresh"]) / p["delta_T"], 20))
        v += h / p["cm"] * (g * (p["v_rest"] - v) + spike - w + p["i_offset"])
        if v >= p["v_spike"]:
            v, refractory = p["v_reset"], p["tau_refrac"]
            w += p["b"]
            spikes.append((k + 1) * h)
    return spikes


@pytest.mark.parametrize(("timestep", "bound_ms"), [("1 ms", 2.0), ("0.1 ms", 1.0)])
def test_an_adaptive_exponential_cell_fires_as_a_float_reference(
    timestep: str, bound_ms: float, cells: Maker, open_brain: Open
) -> None:
    population = cells("n", "EIF_cond_exp_isfa_ista", i_offset=0.9)
    parameters = {name: float(values[0]) for name, values in population.parameters.items()}
    expected = adaptive_reference(parameters, 200)
    spikes = _spikes(open_brain(population, timestep=timestep), 200)
    assert len(spikes) == len(expected) >= 5
    assert np.abs(np.array(spikes) - expected).max() < bound_ms


def gate_rates(u: float) -> list[tuple[float, float]]:
    """Return opening and closing rates (1/ms) of m, h and n (Traub & Miles)."""

    def over(x: float, width: float) -> float:
        return width if abs(x) < 1e-9 else x / (exp(x / width) - 1)

    return [
        (0.32 * over(13 - u, 4), 0.28 * over(u - 40, 5)),
        (0.128 * exp((17 - u) / 18), 4 / (1 + exp((40 - u) / 5))),
        (0.032 * over(15 - u, 5), 0.5 * exp((10 - u) / 40)),
    ]


def hodgkin_huxley_reference(p: dict[str, float], until_ms: float, h: float = 0.002) -> list[float]:
    v, spikes = -65.0, []
    gates = [opening / (opening + closing) for opening, closing in gate_rates(v - p["v_offset"])]
    for k in range(round(until_ms / h)):
        rates = gate_rates(v - p["v_offset"])
        gates = [x + h * (a * (1 - x) - b * x) for x, (a, b) in zip(gates, rates, strict=True)]
        m, inactivation, n = gates
        current = p["i_offset"] + p["gbar_Na"] * m**3 * inactivation * (p["e_rev_Na"] - v)
        current += p["gbar_K"] * n**4 * (p["e_rev_K"] - v) + p["g_leak"] * (p["e_rev_leak"] - v)
        before, v = v, v + h / p["cm"] * current
        if before < -20 <= v:
            spikes.append((k + 1) * h)
    return spikes


@pytest.mark.parametrize("timestep", ["1 ms", "0.1 ms"])
def test_a_hodgkin_huxley_cell_fires_as_a_float_reference(
    timestep: str, cells: Maker, open_brain: Open
) -> None:
    population = cells("n", "HH_cond_exp", i_offset=0.7, v0=-65.0)
    parameters = {name: float(values[0]) for name, values in population.parameters.items()}
    expected = hodgkin_huxley_reference(parameters, 100)
    spikes = _spikes(open_brain(population, timestep=timestep), 100)
    assert len(spikes) == len(expected) >= 5
    assert np.abs(np.array(spikes) - expected).max() < 1.2


def test_hodgkin_huxley_gates_start_as_given_or_at_rest(cells: Maker, open_brain: Open) -> None:
    population = cells("n", "HH_cond_exp", v0=-65.0)
    at_rest = [open_brain(population).read_state(gate, [0])[0] for gate in "mhn"]
    rates = gate_rates(-65.0 + 63.0)
    assert at_rest == pytest.approx([opening / (opening + closing) for opening, closing in rates], rel=0.01)
    initial = {"v": np.array([-65.0]), "h": np.array([0.25])}
    given = Population("n", 1, "HH_cond_exp", population.parameters, initial)
    assert open_brain(given).read_state("h", [0])[0] == pytest.approx(0.25, abs=1e-8)


# -- bad input and reading


def test_an_infinite_threshold_is_never_reached(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_exp", v_thresh=np.inf, i_offset=500.0))
    assert _spikes(brain, 200) == []


@pytest.mark.parametrize(
    ("cell_type", "given", "message"),
    [
        ("IF_curr_exp", {"v_rest": -1e5}, "'n'.*'v_rest'.*-100000"),
        ("IF_curr_exp", {"tau_m": 40000.0}, "'n': tau_m.*40000"),
        ("IF_cond_exp", {"tau_syn_I": 40000.0}, "'n': tau_syn_I.*40000"),
        ("IF_curr_exp", {"cm": 1e-6}, "'n'.*1e-06"),
        ("IF_curr_exp", {"v0": 1e6}, "'n'.*'v'.*1e"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_by_name(
    cell_type: str, given: dict[str, float], message: str, cells: Maker, open_brain: Open, golden: Golden
) -> None:
    with golden.raises(NetworkError, match=message):
        open_brain(cells("n", cell_type, **given))


def test_a_wrong_sign_is_refused_by_projection_and_synapse(
    cells: Maker, spike_source: Maker, connect: Callable[..., Projection], open_brain: Open, golden: Golden
) -> None:
    parts = spike_source("s", []), cells("n", "IF_curr_exp"), connect("s", "n", -1.0, label="wrong")
    with golden.raises(NetworkError, match=r"'wrong'.*0 \(0 -> 0\).*-1"):
        open_brain(*parts)


def test_cells_have_only_the_variables_of_their_type(
    cells: Maker, spike_source: Maker, open_brain: Open, golden: Golden
) -> None:
    brain = open_brain(spike_source("s", []), cells("lif", "IF_curr_exp"), cells("izk", "IZK_cond_exp"))
    assert brain.read_state("v", [2, 1]).tolist() == [-70.0, -65.0]
    assert brain.read_state("u", [2]).tolist() == [-14.0]
    with golden.raises(CapabilityError, match="'lif'.*'u'"):
        brain.read_state("u", [1])
    with golden.raises(CapabilityError, match="'s'.*'v'"):
        brain.read_state("v", [0])


def test_synaptic_state_can_be_given(cells: Maker, open_brain: Open, golden: Golden) -> None:
    parameters = cells("n", "IF_cond_exp").parameters
    initial = {"v": np.array([-65.0]), "gsyn_exc": np.array([0.01])}
    brain = open_brain(Population("n", 1, "IF_cond_exp", parameters, initial))
    assert brain.read_state("gsyn_exc", [0])[0] == pytest.approx(0.01, abs=3.1e-5)
    assert _run(brain, 2) > -65.0
    with golden.raises(NetworkError, match="'isyn'"):
        open_brain(Population("n", 1, "IF_cond_exp", parameters, {"isyn": np.array([0.01])}))
