"""Single neurons agree with the continuous-time references that the event backend is tested by."""

from itertools import product

import pytest
from agreement import ORACLES, errors

from nrp_brain_pynn.simulators import SIMULATORS

FINE, LESS_FINE = "0.01 ms", "0.02 ms"
FIRST_MS, MEDIAN_MS = 0.03, 0.1
ROUGH_FIRST_MS, ROUGH_MEDIAN_MS = 0.15, 0.25
BRIEF = {"IF_curr_exp", "IF_cond_alpha", "Izhikevich"}
"""Cells that run on Brian2 in the ordinary run, because it interprets each step: one of each kind."""


def cases():
    """Return the simulators with each reference; on Brian2 most are left for a run by hand."""
    for name, path in product(("neuron", "brian2"), sorted(ORACLES.glob("*.npz"))):
        is_long = name == "brian2" and path.stem.partition("__")[0] not in BRIEF
        marks = [pytest.mark.simulator(name), *([pytest.mark.heavy] if is_long else [])]
        yield pytest.param(name, path, marks=marks, id=f"{name}-{path.stem}")


@pytest.mark.slow
@pytest.mark.parametrize(("program", "path"), list(cases()))
def test_with_fine_steps_spikes_lie_where_the_reference_has_them(program, path):
    cell_type = path.stem.partition("__")[0]
    known = SIMULATORS[program]
    if cell_type not in known.cells:
        pytest.skip(f"{known.name} has no {cell_type}")
    slow = program == "brian2" and cell_type != "Izhikevich"  # it interprets each step
    found, expected, first_ms, median_ms = errors(program, path, LESS_FINE if slow else FINE)
    rough = cell_type in ("Izhikevich", "HH_cond_exp")
    assert abs(found - expected) <= 1
    assert first_ms < (ROUGH_FIRST_MS if rough else FIRST_MS)
    assert median_ms < (ROUGH_MEDIAN_MS if rough else MEDIAN_MS)
