"""What a script may not ask for is one error that says where, what, and what would be right."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.errors import CapabilityError, NetworkError, NrpError
from nrp_core.network.cells import CELLS
from nrp_core.network.files.script import load_network
from nrp_core.network.pynn import builder

CELL = "a = sim.Population(2, sim.IF_cond_exp(), label='a'); "
CURRENT = "a = sim.Population(2, sim.IF_curr_exp(), label='a'); "
CONNECT = "sim.Projection(a, a, sim.AllToAllConnector(), {}, label='p')"


def joined(synapse: str, cell: str = CELL) -> str:
    return cell + CONNECT.format(synapse)


CASES = {
    # names
    "sim.Population(2, sim.IF_cond_alfa())": "PyNN has no 'IF_cond_alfa'; did you mean 'IF_cond_alpha'?",
    "sim.AllToAlConnector()": "PyNN has no 'AllToAlConnector'; did you mean 'AllToAllConnector'?",
    "sim.OneToOneConnector(weights=2.0)": (
        "OneToOneConnector has no parameter 'weights'; it was PyNN 0.7's; today it is StaticSynapse(weight="
    ),
    CELL + "sim.Projection(a, a, sim.AllToAllConnector(), target='inhibitory')": (
        "a projection has no parameter 'target'; it was PyNN 0.7's; today it is receptor_type"
    ),
    CELL + "sim.Projection(a, a, method=sim.AllToAllConnector())": (
        "a projection has no parameter 'method'; it was PyNN 0.7's; today it is connector"
    ),
    CELL + "sim.Projection(a, a, sim.AllToAllConnector(), receptor='inhibitory')": (
        "a projection has no parameter 'receptor'; did you mean 'receptor_type'?"
    ),
    "sim.IF_cond_exp(tau_n=2)": "IF_cond_exp has no parameter 'tau_n'; did you mean 'tau_m'?",
    CELL + "a.set(tau_n=2)": "population 'a': IF_cond_exp has no parameter 'tau_n'; did you mean 'tau_m'?",
    CELL + "a[:1].set(tau_n=2)": "population 'a': IF_cond_exp has no parameter 'tau_n'",
    CELL + "a.initialize(vv=2)": "population 'a': IF_cond_exp has no state variable 'vv'; did you mean 'v'?",
    "sim.StaticSynapse(wieght=1)": "StaticSynapse has no parameter 'wieght'; did you mean 'weight'?",
    "sim.SpikePairRule(tau_pls=1)": "SpikePairRule has no parameter 'tau_pls'; did you mean 'tau_plus'?",
    "sim.STDPMechanism(timing_dependance=1)":
        "STDPMechanism has no parameter 'timing_dependance'; did you mean 'timing_dependence'?",
    "sim.FixedProbabilityConnector(p_conect=1)": "no parameter 'p_conect'; did you mean 'p_connect'?",
    "sim.DCSource(amplitud=1)": "DCSource has no parameter 'amplitud'; did you mean 'amplitude'?",
    "sim.RandomDistribution('unifrm', low=0)": "there is no distribution 'unifrm'; did you mean 'uniform'?",
    "sim.RandomDistribution('uniform', lo=0)": "'uniform' has no parameter 'lo'; did you mean 'low'?",
    CELL + "sim.Projection(a, a, sim.AllToAllConnector(), receptor_type='exitatory')":
        "projection 'a→a': the cells of 'a' have no receptor 'exitatory'; did you mean 'excitatory'?",
    joined("sim.StaticSynapse()") + ".set(wieght=1)":
        "projection 'p': StaticSynapse has no parameter 'wieght'; did you mean 'weight'?",
    # numbers of cells
    "sim.Population(2, sim.IF_cond_exp(tau_m=float('nan')), label='a')":
        "population 'a': tau_m of cell 0 is nan",
    "sim.Population(2, sim.IF_cond_exp(tau_m=float('inf')), label='a')": "tau_m of cell 0 is inf",
    "sim.Population(2, sim.IF_cond_exp(cm=[1, -1]), label='a')": "population 'a': cm of cell 1 is -1",
    "sim.Population(2, sim.IF_cond_exp(tau_m='fast'), label='a')": "IF_cond_exp: tau_m is 'fast'",
    "sim.Population(2, sim.IF_cond_exp(tau_m=None), label='a')": "IF_cond_exp: tau_m is None",
    "sim.Population(2, sim.IF_cond_exp(tau_m=[1, 2, 3]), label='a')":
        "population 'a': tau_m has 3 values where there are 2",
    CELL + "a.set(tau_m=[1, 2, 3])": "population 'a': tau_m has 3 values where there are 2",
    "sim.Population(2, sim.SpikeSourcePoisson(rate=-3), label='a')": "population 'a': rate of cell 0 is -3",
    "sim.Population(1, sim.SpikeSourceArray(spike_times=[-1, 3]), label='a')":
        "population 'a': the spike times",
    "sim.Population(2, sim.SpikeSourceArray(spike_times=lambda i: 3.0 * i), label='a')":
        "population 'a': spike_times given as a function must be a Sequence",
    "sim.Population(1, sim.IF_cond_exp(tau_m=1j), label='a')": "IF_cond_exp: tau_m is 1j; it must be",
    "sim.Population(1, sim.SpikeSourceArray(spike_times=[3, '4']))": "spike_times is [3, '4']; it must be",
    "sim.Population(3, sim.SpikeSourceArray(spike_times=[[1], [2]]), label='a')":
        "population 'a': spike_times has 2 values where there are 3",
    CELL + "a.initialize(v='rest')": "population 'a': v is 'rest'; it must be a number",
    CELL + "a.initialize(v=[1, 2, 3])": "population 'a': v has 3 values where there are 2",
    CELL + "a[1:].initialize(v=[1, 2])": "population 'a': v has 2 values where there are 1",
    CELL + "a.record('w')": "population 'a': IF_cond_exp has no 'w' to record; valid: gsyn_exc, gsyn_inh,",
    CELL + "a[5:9]": "a view of 'a' by slice(5, 9, None) has no cells; there are 0..1",
    "sim.Population(2.5, sim.IF_cond_exp(), label='a')": "population 'a': its size is 2.5; it must be",
    "sim.Population(0, sim.IF_cond_exp(), label='a')": "population 'a' has no cells",
    "sim.Population(2, 'IF_cond_exp', label='a')":
        "population 'a': its cell type is 'IF_cond_exp'; it must be one such as sim.IF_cond_exp()",
    "sim.Population(2, None, label='a')": "population 'a': its cell type is None; it must be one such as",
    "sim.Population(2, sim.IF_cond_exp(), structure='line', label='a')":
        "population 'a': its structure is 'line'; it must be one such as sim.Line()",
    "sim.Population((2, 0), sim.IF_cond_exp(), label='a')": "population 'a' has no cells: its size is (2, 0)",
    "sim.Population(2, sim.IF_cond_exp(tau_m=lambda i: 1 / 0), label='a')":
        "population 'a': tau_m cannot be computed: ZeroDivisionError: division by zero",
    "sim.Population(5, sim.IF_cond_exp(), structure=sim.Grid3D(), label='a').positions":
        "population 'a': positions cannot be computed: AssertionError",
    "sim.Population(1, sim.SpikeSourceArray(spike_times=5.0), label='a')":
        "population 'a': spike_times is array(5.); it must be a list of times",
    "sim.Population(2, sim.IF_cond_exp(v_reset=[-65, -40]), label='a')":
        "population 'a': v_reset of cell 1 is -40 mV; it must be less than its v_thresh, -50 mV",
    "sim.Population(2, sim.EIF_cond_exp_isfa_ista(v_reset=-30), label='a')":
        "v_reset of cell 0 is -30 mV; it must be less than its v_spike, -40 mV",
    "sim.Population(2, sim.Izhikevich(c=30), label='a')": "c of cell 0 is 30 mV; it must be less than 30 mV",
    "sim.Population(2, sim.IF_cond_exp(), initial_values={'v': float('inf')}, label='a')":
        "population 'a': v of cell 0 is inf; it must be finite",
    "sim.Population(2, sim.HH_cond_exp(), initial_values={'m': 2.0}, label='a')":
        "population 'a': m of cell 0 is 2; it must be between 0 and 1",
    "sim.Population(2, sim.SpikeSourcePoisson(duration=-5.0), label='a')":
        "population 'a': duration of cell 0 is -5; it must be 0 or more",
    CELL + "a[5]": "'a' has no cells at 5; they are numbered 0..1",
    CELL + "a[[0, 7]]": "'a' has no cells at [0, 7]; they are numbered 0..1",
    CELL + "a['x']": "'a' has no cells at 'x'",
    CELL + "(a[:1] + a[1:])[2]": "has no cells at 2; they are numbered 0..1",
    CELL + "a[0].tau_n = 3.0": "population 'a': IF_cond_exp has no parameter 'tau_n'; did you mean 'tau_m'?",
    "sim.IF_cond_exp({'tau_m': 10.0})":
        "IF_cond_exp takes its parameters by name, as IF_cond_exp(v_rest=...), not {'tau_m': 10.0}; those of",
    "sim.StaticSynapse(0.1, 1.0)": "StaticSynapse takes its parameters by name, as StaticSynapse(weight=...)",
    CELL + "a.inject(sim.DCSource)": "population 'a': its current source is DCSource; it must be one such as",
    CELL + "a.record('v', to_file=3)": "population 'a': its file is 3; it must be a name such as",
    "sim.IndexBasedProbabilityConnector('i + j')": "its expression is an object of a subclass of pyNN.core.",
    CELL + "a.record(5)": "population 'a': its list of variables is 5; it must be names such as 'spikes'",
    CELL + "sim.DCSource().inject_into(5)": "DCSource: its target is 5; it must be a population, view,",
    "sim.DCSource().inject_into(sim.Population(1, sim.SpikeSourceArray(), label='s'))":
        "DCSource: cannot inject current into 's', which only emits or repeats spikes",
    CELL + "a.positions = [[1, 2]]": "population 'a': positions are finite numbers (um) of shape (3, 2)",
    "sim.DCSource(amplitude=float('nan'))": "DCSource: amplitude is nan; it must be finite",
    "sim.NoisyCurrentSource(stdev=-1.0)": "NoisyCurrentSource: stdev is -1.0; it must be 0 or more",
    "sim.NoisyCurrentSource(dt=0.0)": "NoisyCurrentSource: dt is 0.0; it must be more than 0 ms",
    # numbers of synapses
    joined("sim.StaticSynapse(delay=-1)"): "projection 'p': delay of synapse 0 (0 -> 0) is -1",
    joined("sim.StaticSynapse(weight=float('nan'))"): "projection 'p': weight of synapse 0 (0 -> 0) is nan",
    joined("sim.StaticSynapse(weight=-1)"):
        "projection 'p': weight of synapse 0 (0 -> 0) is -1; it must be 0 or more",
    joined("sim.StaticSynapse(weight=[[1] * 3] * 3)"):
        "projection 'p': weight has 3 x 3 values where there are 2 x 2",
    joined("sim.StaticSynapse()") + ".set(delay=-2)": "projection 'p': delay of synapse 0 (0 -> 0) is -2",
    joined("sim.TsodyksMarkramSynapse(U=0.5)") + ".initialize(y=0.8, z=0.7)":
        "projection 'p': the initial y and z are shares of one whole, and their sum is 1.5",
    joined("sim.TsodyksMarkramSynapse(U=1.5)"): "projection 'p': U of synapse 0 (0 -> 0) is 1.5",
    CURRENT + "sim.Projection(a, a, sim.AllToAllConnector(), sim.StaticSynapse(weight=1), "
              "receptor_type='inhibitory', label='p')":
        "is 1; it must be 0 or less on the inhibitory receptor",
    "sim.FixedProbabilityConnector(-0.5)": "FixedProbabilityConnector(-0.5): an argument is impossible",
    "sim.FixedNumberPreConnector(n=-1)": "FixedNumberPreConnector(n=-1): an argument is impossible",
    CELL + "sim.Projection(a, a, sim.FromListConnector([(5, 0, 1.0, 1.0)]), label='p')":
        "projection 'p': presynaptic index 5 in its list of synapses; 'a' has cells 0..1",
    "sim.FromListConnector([(0, 1, 1.0, 1.0), (0, 1, 1.0)])":
        "row 1 of the list of synapses is (0, 1, 1.0); all rows have equally many numbers, the first has 4",
    "sim.FromListConnector([('a', 1)])": "row 0 of the list of synapses is ('a', 1)",
    "sim.FromListConnector([(0, 1, 1.0)])": "for rows of 3 numbers column_names must name the parameters",
    CELL + "sim.Projection(a, a, sim.ArrayConnector([[0.0, 0.4]] * 2), label='p')": "0.4 is neither true",
    CELL + "sim.Projection(a, a, sim.ArrayConnector([[True] * 3] * 2), label='p')":
        "projection 'p': array has 2 x 3 values where there are 2 x 2",
    "sim.StaticSynapse(weight='d(')": "StaticSynapse: weight is 'd('. Value should be a string expressing",
    "sim.STDPMechanism(dendritic_delay_fraction=2)": "dendritic_delay_fraction is 2; it must be a",
    joined("sim.STDPMechanism(timing_dependence=sim.SpikePairRule(), "
           "weight_dependence=sim.AdditiveWeightDependence(w_min=2, w_max=1))"):
        "projection 'p': w_min of synapse 0 (0 -> 0) is 2; it must be at most its w_max, 1",
    CELL + "sim.Projection(a, a, sim.AllToAllConnector(), sim.StaticSynapse(weight=lambda i, j: 1), "
           "receptor_type='excitatory', label='p')":
        "projection 'p': its AllToAllConnector fails: TypeError: ",
    joined("sim.StaticSynapse()") + ".set(weight='x')":
        "projection 'p': weight cannot be computed: InvalidParameterValueError: ",
    joined("sim.StaticSynapse()") + ".get('weight', format='dict')": "projection 'p': weight cannot be read",
    joined("sim.StaticSynapse()") + "[50]": "projection 'p' has no synapse 50; they are numbered 0..3",
    joined("sim.StaticSynapse()") + "[0].wieght = 3": "StaticSynapse has no parameter 'wieght'; did you mean",
    joined("sim.StaticSynapse"): "projection 'p': its synapse type is StaticSynapse; it must be one such as",
    CELL + "sim.Projection(a, None, sim.AllToAllConnector(), label='p')":
        "projection 'p': its target is None; it must be a population",
    CELL + "sim.Projection(a, a, 'all', label='p')": "projection 'p': its connector is 'all'; it must be",
    "sim.FixedProbabilityConnector(True)": "p_connect is True; it must be a number between 0 and 1",
    "sim.DCSource(amplitude=[1.0, 2.0])": "DCSource: amplitude is [1.0, 2.0]; it must be one number",
    "sim.FixedProbabilityConnector(1.5)": "p_connect is 1.5; it must be a number between 0 and 1",
    "sim.FixedNumberPreConnector(n=2.5)": "FixedNumberPreConnector(n=2.5): an argument is impossible; n must",
    "sim.DistanceDependentProbabilityConnector('d <')":
        "DistanceDependentProbabilityConnector('d <'): an argument is impossible; invalid syntax",
    "sim.DistanceDependentProbabilityConnector('exp(-D)')":
        "an argument is impossible; name 'D' is not defined; the distance is d",
    "sim.StaticSynapse(weight='exp(-d)')": "name 'exp' is not defined; a function of Python, such as lambda",
    "sim.FromListConnector([0, 1])": "its list of synapses is [0, 1]; each is (pre, post, ...)",
    "sim.STDPMechanism(timing_dependence=5)": "its timing_dependence is 5; it must be one such as",
    joined("sim.STDPMechanism(timing_dependence=sim.Vogels2011Rule(), "
           "weight_dependence=sim.MultiplicativeWeightDependence())"):
        "Vogels2011Rule is defined with AdditiveWeightDependence, not MultiplicativeWeightDependence",
    "sim.PfisterSpikeTripletRule(tau_xx=1)":
        "PfisterSpikeTripletRule has no parameter 'tau_xx'; did you mean 'tau_x'?",
    joined("sim.MultiQuantalSynapse(n=2.5)"):
        "projection 'p': n of synapse 0 (0 -> 0) is 2.5; it must be a whole number from 1 on",
    "sim.StaticSynapse(weight='1/d')": "StaticSynapse: weight is '1/d'. float division by zero",
    "sim.RandomDistribution('normal', mu=1.0)": "the distribution 'normal': Incorrect parameterization",
    "sim.RandomDistribution('normal', mu=1.0, sigma=-3.0)": "'normal': sigma is -3.0, below 0",
    "sim.RandomDistribution('uniform', low=5, high=1)": "'uniform': low is 5, above high, 1",
    # times
    CELL + "sim.run(-3.0)": "run: -3 ms is in the past; the time is 0 ms",
    CELL + "sim.run('10')": "run: the time is a number of ms, not '10'",
    "sim.setup(timestep='x')": "setup: the time step must be more than 0 ms, not x",
    "sim.setup(timestep=0.1, min_delay=2.0, max_delay=1.0)": "setup: min_delay has to be less than",
    "sim.setup(timestep=0.5, max_delay=0.2)": "max_delay (0.2 ms) must be at least the time step (0.5 ms)",
    "sim.setup(timestep=-1)": "the time step must be more than 0 ms, not -1",
}  # fmt: skip


def error_of(text: str, folder: Path) -> NrpError:
    script = folder / "brain.py"
    script.write_text(f"import pyNN.nest as sim\n{text}\n")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        with pytest.raises(NrpError) as caught:
            load_network(script)
    return caught.value


@pytest.mark.parametrize("text", CASES)
def test_a_mistake_is_one_error_with_its_line_and_what_would_be_right(text: str, tmp_path: Path) -> None:
    error = error_of(text, tmp_path)
    assert isinstance(error, NetworkError)
    assert CASES[text] in error.message
    assert (error.path, error.line) == (tmp_path / "brain.py", 2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "sim.IF_facets_hardware1()",
            "IF_facets_hardware1 is not supported; the nearest supported model: IF_cond_exp",
        ),
        ("sim.native_cell_type('iaf_psc_alpha')()", "the nearest standard model is IF_curr_alpha"),
    ],
)
def test_an_unknown_model_is_refused_with_the_nearest_name(text: str, message: str, tmp_path: Path) -> None:
    error = error_of(text, tmp_path)
    assert isinstance(error, CapabilityError)
    assert message in str(error)


@given(st.sampled_from(list(CELLS)), st.data())
@settings(max_examples=50, suppress_health_check=[HealthCheck.too_slow], deadline=None)
def test_a_parameter_that_is_nan_is_named_with_its_cell(cell: str, data: st.DataObject) -> None:
    sim = builder()
    model = getattr(sim, cell)
    names = sorted(name for name in model.default_parameters if name != "spike_times")
    if not names:
        return
    name, size = data.draw(st.sampled_from(names)), data.draw(st.integers(1, 5))
    wrong = data.draw(st.integers(0, size - 1))
    values = np.full(size, float(model.default_parameters[name]))
    values[wrong] = np.nan
    with pytest.raises(NetworkError, match=f"'p': {name}.*{wrong}"):
        sim.Population(size, model(**{name: values}), label="p")


@given(
    receptor=st.sampled_from(["excitatory", "inhibitory"]),
    cell=st.sampled_from(["IF_curr_exp", "IF_cond_exp"]),
    weights=st.lists(st.floats(-2, 2), min_size=1, max_size=6),
)
@settings(deadline=None)
def test_weights_of_the_wrong_sign_and_only_those_are_refused(
    receptor: str, cell: str, weights: list[float]
) -> None:
    sim = builder()
    pre = sim.Population(len(weights), sim.SpikeSourcePoisson(), label="pre")
    post = sim.Population(1, getattr(sim, cell)(), label="post")
    sign = -1.0 if (receptor, cell) == ("inhibitory", "IF_curr_exp") else 1.0
    wrong = [i for i, weight in enumerate(weights) if sign * weight < 0]
    table = [(i, 0, weight, 1.0) for i, weight in enumerate(weights)]

    def connect() -> None:
        sim.Projection(pre, post, sim.FromListConnector(table), receptor_type=receptor, label="p")

    if wrong:
        with pytest.raises(NetworkError, match=rf"'p'.*{wrong[0]} \({wrong[0]} ->"):
            connect()
    else:
        connect()
