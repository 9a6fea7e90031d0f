"""Synapses that change do so on every cell by the same rules, or are refused there."""

import pytest
from nrp_brain_event import EventBackend
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError

from nrp_brain_pynn.simulators import SIMULATORS

CELLS = sorted(SIMULATORS["brian2"].cells)
FINE = "0.05 ms"
SHARE, ROUGH_SHARE = 0.03, 0.2
"""Relative error of the effect due to the step; larger for Hodgkin-Huxley cells, which differ anyway."""


def tired(cell_type):
    """Return what builds a synapse whose resources recover as fast as a synaptic current decays."""

    def build(sim):
        cell = sim.Population(1, getattr(sim, cell_type)(), label="cell")
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=[5.0, 12.0, 20.0]), label="source")
        decay = getattr(sim, cell_type).default_parameters.get("tau_syn_E", 5.0)
        kind = sim.TsodyksMarkramSynapse(weight=0.002, delay=1.0, U=0.5, tau_rec=decay, tau_facil=50.0)
        sim.Projection(source, cell, sim.AllToAllConnector(), kind, label="tired")

    return build


def voltages(brain):
    found = []
    for t_ms in (8, 14, 22, 30):
        brain.run_until(t_ms * NS_PER_MS)
        found.append(float(brain.read_state("v", [0])[0]))
    return found


@pytest.mark.parametrize("cell_type", CELLS)
def test_a_synapse_tires_alike_on_every_cell_or_is_refused(cell_type, simulator, network, opened):
    made, known = network(tired(cell_type)), SIMULATORS[simulator]
    if cell_type not in known.cells - known.untiring:
        with pytest.raises(CapabilityError, match=cell_type):
            opened(made, simulator)
        return
    expected = voltages(opened(made, None, EventBackend()))
    effect = max(expected) - min(expected)
    assert effect > 0.0
    share = ROUGH_SHARE if cell_type == "HH_cond_exp" else SHARE
    found = voltages(opened(made, simulator, timestep=FINE))
    assert found == pytest.approx(expected, rel=0, abs=share * effect)


def plastic(cell_type, weight, potentiation):
    """Return what builds a plastic synapse between cells that fire at certain times."""

    def build(sim):
        cells = sim.Population(2, getattr(sim, cell_type)(), label="cells")
        trains = [[5.0, 30.0, 55.0, 80.0], [8.0, 26.0, 62.0]]
        source = sim.Population(2, sim.SpikeSourceArray(spike_times=trains), label="source")
        strong = sim.StaticSynapse(weight=weight, delay=1.0)
        sim.Projection(source, cells, sim.OneToOneConnector(), strong)
        stdp = sim.STDPMechanism(
            timing_dependence=sim.SpikePairRule(
                tau_plus=20.0, tau_minus=20.0, A_plus=potentiation, A_minus=0.12
            ),
            weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=0.002 * weight),
            weight=0.001 * weight,
            delay=1.0,
        )
        sim.Projection(cells[0:1], cells[1:2], sim.AllToAllConnector(), stdp, label="plastic")

    return build


@pytest.mark.parametrize(
    ("cell_type", "weight"), [("IF_curr_exp", 5.0), ("IF_curr_delta", 25.0), ("Izhikevich", 60.0)]
)
@pytest.mark.parametrize("potentiation", [0.1, 0.0])
def test_a_plastic_weight_changes_alike_on_every_cell(
    cell_type, weight, potentiation, simulator, network, opened
):
    if cell_type not in SIMULATORS[simulator].cells or "stdp" not in SIMULATORS[simulator].synapses:
        pytest.skip("it has no such cells or synapses")
    made, found = network(plastic(cell_type, weight, potentiation)), []
    for brain in (opened(made, None, EventBackend()), opened(made, simulator)):
        brain.run_until(90 * NS_PER_MS)
        found.append(float(brain.read_weights("plastic")[0]) / (0.001 * weight))
    assert 0.3 < found[0] < 0.95
    assert found[1] == pytest.approx(found[0], abs=0.01)
