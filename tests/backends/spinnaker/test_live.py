"""Parameters and weights that change while the machine runs, in its own numbers."""

from collections.abc import Callable

import numpy as np
import pytest
from golden import Golden

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import STDP, TSODYKS_MARKRAM

Maker = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]


def voltages(brain: Brain, neuron: int, until_ms: int) -> list[float]:
    """Return the voltage at the end of every millisecond from now on."""
    found = []
    for t_ms in range(brain.now_ns // NS_PER_MS + 1, until_ms + 1):
        brain.run_until(t_ms * NS_PER_MS)
        found.append(float(brain.read_state("v", [neuron])[0]))
    return found


@pytest.mark.parametrize("cell", ["IF_curr_exp", "IF_cond_alpha", "HH_cond_exp", "EIF_cond_exp_isfa_ista"])
def test_changed_parameters_are_those_of_a_machine_that_began_with_them(
    cells: Maker, open_brain: Open, cell: str
) -> None:
    values = {"cm": 0.31, "i_offset": 0.9, "tau_syn_E": 3.3}
    changed, begun = open_brain(cells("n", cell, 2)), open_brain(cells("n", cell, 2, **values))
    changed.set_parameters([0, 1], values)
    assert voltages(changed, 1, 40) == voltages(begun, 1, 40)


def test_a_dynamic_synapse_follows_the_time_constant_of_its_target(
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open
) -> None:
    def opened(tau_syn: float) -> Brain:
        dynamics = {"U": 0.5, "tau_rec": 30.0, "tau_facil": 10.0}
        synapse = connect("s", "n", 0.6, kind=TSODYKS_MARKRAM, **dynamics)
        source = spike_source("s", [2.0, 6.0, 9.0])
        return open_brain(source, cells("n", "IF_curr_exp", 2, tau_syn_E=tau_syn), synapse)

    changed, begun = opened(2.0), opened(7.0)
    changed.set_parameters([1, 2], {"tau_syn_E": 7.0})
    assert voltages(changed, 1, 40) == voltages(begun, 1, 40)


@pytest.mark.one_of(6)
@pytest.mark.parametrize("kind", ["static", TSODYKS_MARKRAM, STDP])
def test_each_synapse_gets_its_own_weight(
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open, kind: str
) -> None:
    parameters = {
        "static": {},
        TSODYKS_MARKRAM: {"U": 1.0, "tau_rec": 1.0, "tau_facil": 0.0},
        STDP: {
            "A_plus": 0.0,
            "A_minus": 0.0,
            "tau_plus": 20.0,
            "tau_minus": 20.0,
            "w_min": 0.0,
            "w_max": 4.0,
        },
    }[kind]
    rule = {"timing": "SpikePairRule", "weight": "AdditiveWeightDependence"} if kind == STDP else {}
    synapses = connect(
        "s", "n", [-1.0, -2.0, -3.0], pairs=[(1, 0), (0, 1), (1, 2)], receptor="inhibitory", label="all",
        kind=kind, plasticity=rule, **parameters,
    )  # fmt: skip
    brain = open_brain(spike_source("s", [5.0], [5.0]), cells("n", "IF_curr_exp", 3), synapses)
    assert brain.read_weights("all") == pytest.approx([-1.0, -2.0, -3.0], rel=1e-3)
    brain.set_weights("all", [-3.0, 0.0, -1.5])
    brain.run_until(12 * NS_PER_MS)
    below = -65.0 - brain.read_state("v", [2, 3, 4])
    assert below[1] == pytest.approx(0.0, abs=1e-3)
    assert below[0] == pytest.approx(2 * below[2], rel=0.01)


def test_weights_that_do_not_fit_under_the_shift_and_parameters_behind_weights_in_mv_are_refused(
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open, golden: Golden
) -> None:
    brain = open_brain(
        spike_source("s", [5.0]), cells("n", "IF_curr_exp"), cells("jump", "IF_curr_delta"),
        connect("s", "n", 0.5, label="one"), connect("s", "jump", 2.0, label="two"),
    )  # fmt: skip
    with golden.raises(CapabilityError, match="'one'.*1000.*16"):
        brain.set_weights("one", 1000.0)
    assert brain.read_weights("one") == pytest.approx([0.5], rel=1e-3)
    with golden.raises(CapabilityError, match="'jump'.*mV.*tau_m"):
        brain.set_parameters([2], {"tau_m": 30.0})
    with pytest.raises(NetworkError):
        brain.set_parameters([1], {"tau_m": 1e-9})


def test_sources_that_the_machine_draws_change_their_rate_and_a_snapshot_keeps_it(open_brain: Open) -> None:
    values = {"rate": np.full(3, 0.0), "start": np.zeros(3), "duration": np.full(3, 1e9)}
    brain = open_brain(Population("noise", 3, "SpikeSourcePoisson", values), poisson="machine")
    heard = brain.add_sink(SpikeRecorder(), [0, 1, 2], name="heard")
    brain.run_until(100 * NS_PER_MS)
    brain.set_parameters([0, 2], {"rate": [400.0, 5.0]})
    snapshot = brain.snapshot()
    brain.run_until(1100 * NS_PER_MS)
    found = heard.spikes()
    assert found.times_ms.min() > 100.0
    assert 300 < (found.neurons == 0).sum() < 500
    assert 0 < (found.neurons == 2).sum() < 20
    brain.reset()
    brain.run_until(100 * NS_PER_MS)
    assert not len(heard.spikes())
    brain.restore(snapshot)
    brain.run_until(1100 * NS_PER_MS)
    assert (heard.spikes().times_ms == found.times_ms).all()
