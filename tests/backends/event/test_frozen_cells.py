"""IF_curr_exp_frozen: nothing moves or arrives in its refractory period, and spikes reset its input."""

from collections.abc import Callable

import numpy as np
import pytest
from nrp_conformance.brain.kit import SAMPLES, cells, connect, spikes
from nrp_conformance.brain.reference import Arrival, ReferenceTrace, simulate

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain

SAMPLE = SAMPLES["IF_curr_exp_frozen"]
EMITTED = [5.0, 8.0, 11.0, 14.5, 19.0, 22.0, 22.5, 24.0, 31.0, 38.0, 40.0, 45.0, 60.0]
STRONG, DELAY_MS, UNTIL_MS = 130.0, 1.0, 70.0


def reference(kind: str) -> ReferenceTrace:
    """Return the response of the cell, or of one that is like it except for its synapses."""
    arrivals = [Arrival(t + DELAY_MS, STRONG) for t in EMITTED]
    if kind == SAMPLE.cell_type:
        return simulate(SAMPLE, arrivals, until_ms=UNTIL_MS)
    per_mv = SAMPLE.parameters["cm"] / SAMPLE.parameters["tau_m"]
    scaled = [Arrival(one.time_ms, one.weight * per_mv) for one in arrivals]
    return simulate(SAMPLES[kind], scaled, until_ms=UNTIL_MS)


def fired(brain: Brain) -> list[float]:
    recorder = brain.add_sink(SpikeRecorder(), np.array([1]), name="n")
    brain.run_until(round(UNTIL_MS * 1e6))
    return recorder.spikes().times_ms.tolist()


@pytest.mark.parametrize(("resolution", "tolerance_ms"), [(None, 0.02), ("0.1 ms", 0.3)])
def test_a_frozen_cell_fires_when_its_equations_say(
    open_brain: Callable[..., Brain], resolution: str | None, tolerance_ms: float
) -> None:
    expected = reference(SAMPLE.cell_type).spikes
    assert len(expected) >= 4
    assert len(expected) != len(reference("IF_curr_exp").spikes)  # what arrives in between is lost
    parts = [spikes("s", EMITTED), cells(SAMPLE, "n"), connect("s", "n", STRONG, DELAY_MS)]
    found = fired(open_brain(*parts, resolution=resolution))
    assert found == pytest.approx(expected, abs=tolerance_ms)


@pytest.mark.parametrize("resolution", [None, "0.1 ms"])
def test_the_input_of_a_frozen_cell_is_a_voltage_whatever_its_membrane_becomes(
    open_brain: Callable[..., Brain], resolution: str | None
) -> None:
    def voltage(**first: float) -> float:
        """Return the voltage 9 ms after a weak spike; the capacitance changes after it, or is so at first."""
        cell = cells(SAMPLE, "n", **first)
        brain = open_brain(
            spikes("s", [1.0]), cell, connect("s", "n", SAMPLE.weak, 1.0), resolution=resolution
        )
        brain.run_until(2_500_000)
        brain.set_parameters(np.array([1]), {"cm": 0.75})
        brain.run_until(11_000_000)
        return float(brain.read_state("v", [1])[0])

    assert voltage() == pytest.approx(voltage(cm=0.75), abs=1e-9)
    assert voltage() > SAMPLE.parameters["v_rest"] + 0.1
