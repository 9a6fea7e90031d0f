"""What the backend declares, loads and refuses."""

import pickle
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event import EventBackend, EventOptions
from pydantic import ValidationError
from pyNN.standardmodels import cells as standard_cells

from nrp_core.brain.backends import brains
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import CapabilityError, DivergedError, LifecycleError, NetworkError
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import TSODYKS_MARKRAM

Cells = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]


def test_it_is_found_by_its_name() -> None:
    assert isinstance(brains().load("event"), EventBackend)


def test_looking_at_it_does_not_load_the_compiler() -> None:
    code = (
        "import sys, nrp_brain_event as e; e.EventBackend().capabilities(e.EventOptions());"
        "sys.exit('numba' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


CELLS_OF_PYNN = [
    cell for cell in EventBackend().capabilities(EventOptions()).cells if hasattr(standard_cells, cell)
]


@pytest.mark.parametrize("cell_type", sorted(CELLS_OF_PYNN))
def test_a_cell_shows_the_variables_that_pynn_records_of_it(
    cell_type: str, cells: Cells, open_brain: Open, golden: Golden
) -> None:
    brain = open_brain(cells("a", cell_type))
    brain.run_until(5 * NS_PER_MS)
    recordable = set(getattr(standard_cells, cell_type).recordable) - {"spikes"}
    for name in brain.capabilities.state_variables & recordable:
        assert np.isfinite(brain.read_state(name, [0])).all()
        recordable.remove(name)
    assert recordable == set()
    others = brain.capabilities.state_variables - set(getattr(standard_cells, cell_type).recordable)
    for name in sorted(others):
        with golden.raises(CapabilityError, match=f"'a'.*'{name}'"):
            brain.read_state(name, [0])


def test_a_state_that_was_saved_as_arrays_is_restored(cells: Cells, open_brain: Open) -> None:
    """Version 0.1 did so; it is a third of the state here, and the rest is as it is saved today."""
    brain = open_brain(cells("a", "IF_cond_exp", 2, i_offset=0.6))
    brain.run_until(30 * NS_PER_MS)
    today = brain.snapshot()
    brain.run_until(60 * NS_PER_MS)
    later = brain.read_state("v", [0, 1]).tobytes()
    *rest, state, began_ns, frozen, changed = pickle.loads(today.payload)
    arrays: Any = brain._engine._asdict()  # type: ignore[attr-defined]
    for name in ("cells", "events", "clock"):
        state[name] = np.frombuffer(state[name], arrays[name].dtype)
    brain.restore(replace(today, payload=pickle.dumps((*rest, state, began_ns, frozen, changed))))
    brain.run_until(60 * NS_PER_MS)
    assert brain.read_state("v", [0, 1]).tobytes() == later


@pytest.mark.parametrize("tolerance", [0.0, -1.0, 1.0])
def test_an_impossible_tolerance_is_refused(tolerance: float, golden: Golden) -> None:
    with golden.raises(ValidationError):
        EventOptions(tolerance=tolerance)


def test_a_smaller_tolerance_brings_the_result_nearer_to_the_truth(cells: Cells, open_brain: Open) -> None:
    def voltage(tolerance: float) -> float:
        brain = open_brain(cells("a", "HH_cond_exp", i_offset=0.6), tolerance=tolerance)
        brain.run_until(100 * NS_PER_MS)
        return float(brain.read_state("v", [0])[0])

    truth = voltage(1e-12)
    errors = [abs(voltage(tolerance) - truth) for tolerance in (1e-4, 1e-6, 1e-8)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-6


def test_negligible_and_huge_weights_are_handled(cells: Cells, open_brain: Open) -> None:
    brain = open_brain(*(cells(kind, kind) for kind in ("IF_curr_alpha", "IF_cond_exp")))
    for weight in (1e-200, 1e-12, 50.0):
        events = SynapticEvents(np.arange(2), np.full(2, 1.0), np.full(2, weight))
        brain._do_inject(events)
    brain.run_until(50 * NS_PER_MS)
    assert np.isfinite(brain.read_state("v", [0, 1])).all()


def test_how_high_the_peak_of_an_exponential_cell_is_set_hardly_matters(
    cells: Cells, open_brain: Open, spikes_of: Callable[..., Spikes]
) -> None:
    values = {"delta_T": 0.8, "i_offset": 1.0, "tau_refrac": 2.0}

    def times_ms(v_spike: float) -> list[float]:
        cell = cells("a", "EIF_cond_exp_isfa_ista", v_spike=v_spike, **values)
        return spikes_of(open_brain(cell), 200.0).times_ms.tolist()

    assert len(times_ms(0.0)) == 8
    for v_spike in (-40.0, 40.0, 1e6, np.inf):
        assert times_ms(v_spike) == pytest.approx(times_ms(0.0), abs=1e-3)
    assert times_ms(np.inf) == pytest.approx(times_ms(40.0), abs=1e-7)


def test_a_neuron_that_cannot_be_integrated_is_named(cells: Cells, open_brain: Open, golden: Golden) -> None:
    brain = open_brain(cells("calm", "IF_cond_exp", 2), cells("wild", "IF_cond_exp", 3))
    brain._do_inject(SynapticEvents(np.array([4]), np.array([7.0]), np.array([1e300])))
    with golden.raises(DivergedError, match="'wild'"):
        brain.run_until(20 * NS_PER_MS)
    with golden.raises(LifecycleError):
        brain.run_until(30 * NS_PER_MS)
    brain.reset()
    brain.run_until(20 * NS_PER_MS)


@pytest.mark.parametrize(
    ("cell_type", "changes", "says"),
    [
        ("IF_curr_exp", {"tau": 3.0}, r"'odd' \(IF_curr_exp\).*'tau'.*'tau_m'"),
        ("IF_cond_exp", {"e_rev_E": np.inf}, "e_rev_E"),
        ("IF_curr_exp", {"tau_m": [1.0, np.inf]}, "tau_m"),
        ("IF_curr_delta", {"v_reset": [-60.0, -50.0]}, "v_reset.*-50 mV"),
        ("Izhikevich", {"c": 30.0}, "30 mV.*30 mV"),
        ("IF_curr_exp", {"initial": {"w": 0.0}}, "'w'"),
    ],
)
def test_impossible_cells_are_refused(
    cell_type: str, changes: dict[str, object], says: str, cells: Cells, open_brain: Open, golden: Golden
) -> None:
    with golden.raises(NetworkError, match=says):
        open_brain(cells("odd", cell_type, 2, **changes))


def test_a_missing_parameter_is_named(cells: Cells, open_brain: Open, golden: Golden) -> None:
    whole = cells("a", "IF_curr_exp")
    parameters = {name: values for name, values in whole.parameters.items() if name != "cm"}
    with golden.raises(NetworkError, match=r"'a' \(IF_curr_exp\).*'cm'"):
        open_brain(Population("a", 1, "IF_curr_exp", parameters))


@pytest.mark.parametrize("delay_ms", [0.0, 9e-7])
def test_a_spike_cannot_be_at_two_neurons_at_once(
    delay_ms: float, cells: Cells, connect: Connect, open_brain: Open, golden: Golden
) -> None:
    with golden.raises(NetworkError, match=f"'a-a-excitatory'.*{delay_ms:g}.*1e-06"):
        open_brain(cells("a", "IF_curr_exp", 2), connect("a", "a", 0.1, delay_ms, pairs=[(0, 1)]))


def test_short_term_plasticity_needs_its_parameters(
    cells: Cells, connect: Connect, open_brain: Open, golden: Golden
) -> None:
    with golden.raises(NetworkError, match="'tau_rec', 'tau_facil'"):
        open_brain(cells("a", "IF_curr_exp"), connect("a", "a", 0.1, kind=TSODYKS_MARKRAM, U=0.5))


def test_a_network_without_neurons_or_synapses_runs(
    cells: Cells, spike_source: Cells, open_brain: Open, spikes_of: Callable[..., Spikes]
) -> None:
    assert len(spikes_of(open_brain(spike_source("only", [1.0, 2.0])), 10.0)) == 2
    assert len(spikes_of(open_brain(cells("only", "IF_curr_exp")), 10.0)) == 0


def test_initial_conductances_and_gates_are_where_the_network_puts_them(
    cells: Cells, open_brain: Open
) -> None:
    brain = open_brain(
        cells("a", "IF_cond_exp", initial={"gsyn_exc": 0.003, "gsyn_inh": 0.001, "v": -60.0}),
        cells("b", "HH_cond_exp", 2, initial={"m": [0.0, 1.0], "h": 1.0, "n": 0.0}),
    )
    assert brain.read_state("gsyn_exc", [0])[0] == 0.003
    assert brain.read_state("gsyn_inh", [0])[0] == 0.001
    assert brain.read_state("v", [0])[0] == -60.0
    brain.run_until(NS_PER_MS // 100)
    closed, opened = brain.read_state("v", [1, 2])
    assert opened > closed + 50.0


def test_it_computes_the_same_without_compiling(capsys: pytest.CaptureFixture[str]) -> None:
    code = """if True:
        import numpy as np
        from nrp_brain_event import EventBackend, EventOptions
        from nrp_core.network.data import Network, Population
        values = dict(a=0.02, b=0.2, c=-65.0, d=2.0, i_offset=0.008)
        cells = Population("a", 1, "Izhikevich", {name: np.array([v]) for name, v in values.items()})
        brain = EventBackend().open(Network({"a": cells}), seed=1, options=EventOptions())
        brain.run_until(60_000_000)
        print(brain.read_state("v", [0])[0])
    """
    exec(code, {})
    compiled = float(capsys.readouterr().out)
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env={"NUMBA_DISABLE_JIT": "1"}, check=True, capture_output=True, text=True)
    assert float(done.stdout) == pytest.approx(compiled, abs=1e-6)
