"""Single neurons agree with the continuous-time references that the event backend is tested by."""

import pytest
from agreement import ORACLES, errors

from nrp_brain_pynn.simulators import SIMULATORS

FINE, LESS_FINE = "0.01 ms", "0.02 ms"
FIRST_MS, MEDIAN_MS = 0.03, 0.1
ROUGH_FIRST_MS, ROUGH_MEDIAN_MS = 0.15, 0.25


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(ORACLES.glob("*.npz")), ids=lambda path: path.stem)
def test_with_fine_steps_spikes_lie_where_the_reference_has_them(simulator, path):
    cell_type = path.stem.partition("__")[0]
    known = SIMULATORS[simulator]
    if cell_type not in known.cells:
        pytest.skip(f"{known.name} has no {cell_type}")
    slow = simulator == "brian2" and cell_type != "Izhikevich"  # it interprets each step
    found, expected, first_ms, median_ms = errors(simulator, path, LESS_FINE if slow else FINE)
    rough = cell_type in ("Izhikevich", "HH_cond_exp")
    assert abs(found - expected) <= 1
    assert first_ms < (ROUGH_FIRST_MS if rough else FIRST_MS)
    assert median_ms < (ROUGH_MEDIAN_MS if rough else MEDIAN_MS)
