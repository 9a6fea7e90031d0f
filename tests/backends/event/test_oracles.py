"""Single neurons against continuous-time references: those in ``oracles`` and any that are given."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.devices.sources import DCSource
from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds
from nrp_core.network.data import Population, Projection

OWN = sorted((Path(__file__).parent / "oracles").glob("*.npz"))
JUMPING = ("IF_curr_delta", "Izhikevich")


@dataclass
class Reference:
    """A file of references; see ``oracles/README.md``."""

    path: Path
    meta: dict = field(init=False)

    def __post_init__(self) -> None:
        with np.load(self.path) as arrays:
            self.arrays = {name: arrays[name] for name in arrays.files}
        self.meta = json.loads(str(self.arrays["meta"]))

    def __getitem__(self, name: str) -> np.ndarray:
        return self.arrays[name]

    @property
    def tolerances(self) -> tuple[float, float]:
        """Of spike times (ms) and voltages (mV)."""
        return (1e-7, 1e-6) if self.meta["model"].startswith("IF_curr") else (1e-5, 1e-4)

    @property
    def far_from_spikes(self) -> np.ndarray:
        """Samples whose voltage does not depend on the last digits of a spike time."""
        distance_ms = 1.0 if self.meta["model"] == "HH_cond_exp" else 0.1
        gaps = np.abs(self["truth_t"][:, None] - np.append(self["truth_spikes"], np.inf))
        return gaps.min(axis=1) > distance_ms

    def jumps(self) -> np.ndarray:
        """What inputs add to the voltage at the very time of each sample, mV."""
        total = np.zeros(len(self["truth_t"]))
        if self.meta["model"] in JUMPING:
            for name, weight in (("exc", self.meta["w_e"]), ("inh", self.meta["w_i"])):
                now = np.isclose(self["truth_t"][:, None], self[name], rtol=0.0, atol=1e-9)
                total += weight * now.sum(axis=1)
        return total


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Check each file in a test of its own."""
    paths = [*OWN, *(path for path in metafunc.config.getoption("oracle") if path.suffix == ".npz")]
    metafunc.parametrize("reference", [pytest.param(Reference(path), id=path.stem) for path in paths])


@pytest.mark.one_of(6)
def test_spikes_and_voltages_agree_with_the_reference(
    reference: Reference,
    cells: Callable[..., Population],
    spike_source: Callable[..., Population],
    connect: Callable[..., Projection],
    open_brain: Callable[..., Brain],
) -> None:
    meta = reference.meta
    brain = open_brain(
        cells("cell", meta["model"], initial={"v": meta["v0"]}, **meta["params"]),
        spike_source("exc", reference["exc"]),
        spike_source("inh", reference["inh"]),
        connect("exc", "cell", meta["w_e"], 0.0),
        connect("inh", "cell", meta["w_i"], 0.0, receptor="inhibitory"),
    )
    times_ms, voltages = follow(brain, reference)
    spike_tolerance_ms, voltage_tolerance_mv = reference.tolerances
    np.testing.assert_allclose(times_ms, reference["truth_spikes"], rtol=0.0, atol=spike_tolerance_ms)
    # where an input makes the voltage jump, the reference may show either side of the jump
    after = np.abs(voltages - reference["truth_v"])
    before = np.abs(voltages - reference.jumps() - reference["truth_v"])
    errors = np.minimum(after, before)[reference.far_from_spikes]
    assert errors.max() < voltage_tolerance_mv


def follow(brain: Brain, reference: Reference) -> tuple[np.ndarray, np.ndarray]:
    """Return the spikes of neuron 0 and its voltage at the times of the reference."""
    recorder = brain.add_sink(SpikeRecorder(), [0], name="spikes")
    current = brain.add_source(DCSource(), [0], name="current")
    steps = {from_milliseconds(time_ms): amplitude for time_ms, amplitude in reference["steps"]}
    samples = {from_milliseconds(time_ms) for time_ms in reference["truth_t"]}
    voltages = []
    for t_ns in sorted(samples | steps.keys()):
        brain.run_until(t_ns)
        current.amplitude = steps.get(t_ns, current.amplitude)
        if t_ns in samples:
            voltages.append(brain.read_state("v", [0])[0])
    return recorder.spikes().times_ms, np.array(voltages)
