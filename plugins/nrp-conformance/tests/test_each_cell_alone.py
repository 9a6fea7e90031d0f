"""A brain of one kind of cell can conform, whichever that is."""

from __future__ import annotations

from dataclasses import replace

import pytest
from nrp_brain_event import EventBackend
from nrp_brain_event.cell_types import CELL_TYPES
from nrp_conformance import BrainBackendTests
from nrp_conformance.brain.kit import SAMPLES
from nrp_conformance.report import Outcome
from nrp_conformance.run import run_tests

from nrp_core.brain.backend import BrainOptions
from nrp_core.brain.interface import BrainCapabilities

DIFFERENT = {"IF_curr_delta", "IF_cond_exp", "Izhikevich"}
"""Cells without a synaptic current, with a conductance, and with no refractory time."""
CELLS = [
    pytest.param(name, marks=() if name in DIFFERENT else pytest.mark.heavy)
    for name in SAMPLES
    if name in CELL_TYPES
]


@pytest.mark.one_of(6)
@pytest.mark.parametrize("cell", CELLS)
def test_a_brain_with_one_cell_type_passes_the_tests_that_concern_it(cell: str):
    class OneCell(EventBackend):
        def capabilities(self, options: BrainOptions) -> BrainCapabilities:
            return replace(super().capabilities(options), cells=frozenset({cell}))

    class Tests(BrainBackendTests):
        @classmethod
        def make_backend(cls) -> OneCell:
            return OneCell()

    results = run_tests(Tests)
    assert len(results) > 80
    assert {r.test: r.reason for r in results if r.outcome is Outcome.FAILED} == {}
