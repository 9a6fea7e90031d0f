"""On the grid a neuron has, at each point, the state that it has in the exact mode."""

from collections.abc import Callable

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event import EventBackend, EventOptions

from nrp_core.brain.devices.sources import DCSource, FixedFrequencySource
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes
from nrp_core.clock import NS_PER_MS, from_milliseconds
from nrp_core.errors import CapabilityError, DivergedError, TimestepError
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import TSODYKS_MARKRAM

Cells = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]

CELLS = sorted(EventBackend().capabilities(EventOptions()).cells)
WEAK = {
    "IF_curr_delta": 0.5,
    "Izhikevich": 0.5,
    "IF_curr_exp": 0.1,
    "IF_curr_alpha": 0.1,
    "IF_curr_exp_frozen": 0.5,
}
TRAIN = [1.0, 3.5, 3.5, 4.2, 9.9, 15.0]


def weight_of(cell_type: str, receptor: str) -> float:
    sign = -1 if receptor == "inhibitory" and "_cond_" not in cell_type else 1
    return sign * WEAK.get(cell_type, 0.002)


def states(brain: Brain, neuron: int, variables: list[str]) -> np.ndarray:
    found = []
    for t_ms in np.arange(0.5, 40.0, 0.5):
        brain.run_until(from_milliseconds(t_ms))
        found.append([brain.read_state(name, [neuron])[0] for name in variables])
    return np.array(found)


@pytest.mark.parametrize("cell_type", CELLS)
def test_the_state_equals_that_of_the_exact_mode(
    cell_type: str, cells: Cells, connect: Connect, spike_source: Cells, open_brain: Open
) -> None:
    network = (
        spike_source("s", TRAIN, [2.0, 8.0]),
        cells("n", cell_type),
        connect("s", "n", weight_of(cell_type, "excitatory"), 1.0),
        connect("s", "n", weight_of(cell_type, "inhibitory"), 2.0, pairs=[(1, 0)], receptor="inhibitory"),
    )
    exact, gridded = open_brain(*network), open_brain(*network, resolution="0.1 ms")
    shown = [name for name in ("v", "u", "w", "gsyn_exc", "gsyn_inh") if name in variables_of(cell_type)]
    difference = np.abs(states(exact, 2, shown) - states(gridded, 2, shown))
    assert np.ptp(states(open_brain(*network), 2, ["v"])) > 0.01
    assert difference.max() < 1e-6


@pytest.mark.parametrize("cell_type", [name for name in CELLS if name.startswith("IF_")])
def test_a_few_neurons_advance_like_many_neurons(
    cell_type: str, cells: Cells, connect: Connect, spike_source: Cells, open_brain: Open
) -> None:
    """Few go one by one, many in loops that are compiled to vectors: not a bit differs."""

    def found(n: int) -> np.ndarray:
        synapses = [
            connect(
                "s", "n", 3 * weight_of(cell_type, receptor), 1.0 + k,
                pairs=[(k, j) for j in range(n)], receptor=receptor,
            )
            for k, receptor in enumerate(("excitatory", "inhibitory"))
        ]  # fmt: skip
        driven = cells("n", cell_type, n, i_offset=np.resize([0.0, 0.5, 1.3], n))
        brain = open_brain(spike_source("s", TRAIN, [2.0, 8.0]), driven, *synapses, resolution="0.1 ms")
        return states(brain, 4, ["v"])

    assert (found(4) == found(100)).all()


def variables_of(cell_type: str) -> tuple[str, ...]:
    from nrp_brain_event.cell_types import CELL_TYPES

    return CELL_TYPES[cell_type].state_variables


@pytest.mark.parametrize("cell_type", ["IF_curr_exp", "IF_cond_alpha", "EIF_cond_exp_isfa_ista"])
def test_a_spike_is_that_of_the_next_grid_point(
    cell_type: str, cells: Cells, open_brain: Open, spikes_of: Callable[..., Spikes]
) -> None:
    driven = cells("n", cell_type, i_offset=1.2, v_rest=-65.0, tau_refrac=5.0, initial={"v": -65.0})
    exact = spikes_of(open_brain(driven), 12.0).times_ms[:1]
    found = spikes_of(open_brain(driven, resolution="0.1 ms"), 12.0).times_ms[:1]
    assert found == pytest.approx(np.ceil(exact * 10) / 10, abs=1e-12)


@pytest.mark.parametrize("resolution", [None, "0.1 ms"])
def test_a_network_without_cells_runs(
    resolution: str | None, open_brain: Open, spike_source: Callable[..., Population],
    spikes_of: Callable[..., Spikes],
) -> None:  # fmt: skip
    options = {"resolution": resolution} if resolution else {}
    assert spikes_of(open_brain(spike_source("s", [2.0, 8.0]), **options), 10.0).times_ms.tolist() == [2, 8]
    assert len(spikes_of(open_brain(**options), 10.0).times_ms) == 0


def test_a_refractory_cell_stays_at_its_reset_voltage(cells: Cells, open_brain: Open) -> None:
    driven = cells("n", "IF_curr_exp", i_offset=5.0, tau_refrac=3.0, v_reset=-70.0)
    brain = open_brain(driven, resolution="0.1 ms")
    voltages = []
    for k in range(1, 120):
        brain.run_until(k * NS_PER_MS // 10)
        voltages.append(float(brain.read_state("v", [0])[0]))
    held = np.array(voltages) == -70.0
    first = int(np.argmax(held))
    assert held[first : first + 31].all()  # the point of the spike and 30 steps
    assert not held[:first].any()
    assert not held[first + 31]


def test_cells_of_different_parameters_stand_side_by_side(
    cells: Cells, open_brain: Open, spikes_of: Callable[..., Spikes]
) -> None:
    drive, thresholds = np.linspace(0.8, 2.0, 40), np.linspace(-58.0, -50.0, 40)
    together = cells("n", "IF_curr_exp", 40, i_offset=drive, v_thresh=thresholds, tau_m=[10.0, 20.0] * 20)
    found = spikes_of(open_brain(together, resolution="0.1 ms"), 60.0)
    for k in (0, 17, 39):
        alone = cells(
            "n", "IF_curr_exp", i_offset=drive[k], v_thresh=thresholds[k], tau_m=[10.0, 20.0][k % 2]
        )
        expected = spikes_of(open_brain(alone, resolution="0.1 ms"), 60.0).times_ms
        assert len(expected) >= 2
        assert found.times_ms[found.neurons == k].tolist() == expected.tolist()


def test_currents_and_devices_reach_every_kind_of_cell(
    cells: Cells, open_brain: Open, spikes_of: Callable[..., Spikes]
) -> None:
    for cell_type in CELLS:
        network = (cells("quiet", cell_type), cells("n", cell_type, 2))
        gridded, exact = open_brain(*network, resolution="0.1 ms"), open_brain(*network)
        for brain in (gridded, exact):
            brain.add_source(DCSource(amplitude=0.002), [2], name="dc")
            spec = FixedFrequencySource(rate=100.0, weight=weight_of(cell_type, "excitatory"), delay=1.0)
            brain.add_source(spec, [1], name="train")
            brain.run_until(35 * NS_PER_MS)
        difference = gridded.read_state("v", [0, 1, 2]) - exact.read_state("v", [0, 1, 2])
        assert np.abs(difference).max() < 1e-6, cell_type


def test_short_term_plasticity_is_that_of_the_exact_mode(
    cells: Cells, connect: Connect, spike_source: Cells, open_brain: Open
) -> None:
    parameters = {"U": [0.5, 0.3, 0.7], "tau_rec": 80.0, "tau_facil": [0.0, 50.0, 20.0]}
    network = (
        spike_source("s", TRAIN, [2.0, 8.0, 12.0]),
        cells("n", "IF_cond_exp", 2),
        connect(
            "s", "n", [0.004, 0.002, 0.003], [1.0, 2.0, 1.5], pairs=[(1, 1), (0, 1), (0, 0)],
            kind=TSODYKS_MARKRAM, **parameters,
        ),
    )  # fmt: skip
    exact, gridded = open_brain(*network), open_brain(*network, resolution="0.1 ms")
    for neuron in (2, 3):
        exact.reset()
        gridded.reset()
        assert np.abs(states(exact, neuron, ["v"]) - states(gridded, neuron, ["v"])).max() < 1e-6


def test_a_time_off_the_grid_is_refused(cells: Cells, open_brain: Open, golden: Golden) -> None:
    with golden.raises(TimestepError, match=r"0\.1.*0\.25"):
        open_brain(cells("n", "IF_curr_exp"), resolution="0.1 ms").run_until(250_000)


def test_a_cell_that_cannot_be_integrated_is_named(cells: Cells, open_brain: Open, golden: Golden) -> None:
    brain = open_brain(cells("n", "IF_curr_exp"), cells("wild", "IF_cond_exp", 3), resolution="0.1 ms")
    brain.add_source(FixedFrequencySource(rate=1000.0, weight=1.5e308, n=2), [2], name="train")
    with golden.raises(DivergedError, match="'wild'"):
        brain.run_until(2 * NS_PER_MS)


def test_a_variable_that_a_cell_has_not_is_refused(cells: Cells, open_brain: Open, golden: Golden) -> None:
    with golden.raises(CapabilityError, match="'n'.*'gsyn_exc'"):
        open_brain(cells("n", "IF_curr_exp"), resolution="0.1 ms").read_state("gsyn_exc", [0])
