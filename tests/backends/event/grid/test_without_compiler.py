"""Without a compiler the grid computes the same, slower."""

import json
import os
import subprocess
import sys

import pytest

PROGRAM = """
import json
import numpy as np
from nrp_brain_event import EventBackend, EventOptions
from nrp_brain_event.cell_types import CELL_TYPES
from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_conformance.brain.kit import cells, connect, network
from nrp_conformance.brain.kit import SAMPLES
from nrp_core.network.data import Population, Projection

noise = Population("noise", 4, "SpikeSourcePoisson", {
    "rate": np.full(4, 800.0), "start": np.zeros(4), "duration": np.full(4, 1e9),
})
own = {name: sample for name, sample in SAMPLES.items() if name in CELL_TYPES}
each = np.arange(4, dtype=np.int32)
busy = [cells(sample, name, 4, i_offset=sample.current_na) for name, sample in own.items()]
strong = SAMPLES["IF_curr_exp"].strong
onto = Projection(
    "p", "noise", "IF_curr_exp", "excitatory", each, each, np.full(4, strong / 9), np.full(4, 1.5)
)
tiring = Projection(
    "t", "noise", "IF_curr_exp", "excitatory", each, each, np.full(4, strong / 9), np.full(4, 1.0),
    "tsodyks_markram", {"U": np.full(4, 0.5), "tau_rec": np.full(4, 20.0), "tau_facil": np.zeros(4)},
)
inside = [
    connect(name, name, sample.weak, [1.0, 2.5], pairs=[(0, 1), (2, 3)]) for name, sample in own.items()
]
options = EventOptions(resolution="0.1 ms", poisson="grid")
with EventBackend().open(network(noise, *busy, onto, tiring, *inside), seed=1, options=options) as brain:
    recorder = brain.add_sink(SpikeRecorder(), np.arange(40), name="all")
    brain.run_until(4_000_000)
    spikes = recorder.spikes()
    print(json.dumps([spikes.neurons.tolist(), spikes.times_ms.tolist()]))
"""

EQUATIONS = """
import json
import numpy as np
from nrp_brain_event import EventBackend, EventOptions
from nrp_core.brain import builder
from nrp_core.brain.devices.sinks import SpikeRecorder

sim = builder()
sim.setup(timestep=0.1)
parameters = {"tau": "20 ms", "cm": "1 nF", "tau_s": "5 ms", "i_offset": "1.2 nA", "d": "2 mV"}
leaky = "dv/dt = -v/tau + (g + i_offset)/cm : mV (unless refractory)\\ndg/dt = -g/tau_s : nA"
curved = leaky.replace("-v/tau", "(d*exp((v - 13*mV)/d) - v)/tau")
noise = sim.Population(4, sim.SpikeSourcePoisson(rate=800.0))
for texts in (leaky, curved):
    kind = sim.EquationCell(
        texts, "v > 15*mV", "v = 0*mV", "2 ms", receptors={"excitatory": "g"}, parameters=parameters
    )
    cells = sim.Population(4, kind(tau=[10.0, 15.0, 20.0, 25.0]))
    sim.Projection(noise, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=0.3, delay=1.0))
options = EventOptions(resolution="0.1 ms", lazy=LAZY)
with EventBackend().open(sim.network(), seed=1, options=options) as brain:
    recorder = brain.add_sink(SpikeRecorder(), np.arange(12), name="all")
    brain.run_until(30_000_000)
    spikes = recorder.spikes()
    print(json.dumps([spikes.neurons.tolist(), spikes.times_ms.tolist()]))
"""

SNAPSHOT = """
import json
import numpy as np
from nrp_core.brain.backends import brains
from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.pynn import new_simulator

sim = new_simulator()
sim.setup(timestep=0.1)
noise = sim.Population(4, sim.SpikeSourcePoisson(rate=800.0))
cells = sim.Population(4, sim.IF_curr_exp(i_offset=1.2))
learning = sim.STDPMechanism(
    sim.SpikePairRule(A_plus=0.1, A_minus=0.1), sim.AdditiveWeightDependence(w_max=4.0), weight=2.0, delay=3.0
)
sim.Projection(noise, cells, sim.OneToOneConnector(), learning, label="p")
sim.Projection(cells, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=0.1, delay=2.0), label="q")
backend = brains().load("event")
options = backend.options.model_validate({"resolution": "0.1 ms", "lazy": "never"})
with backend.open(sim.network(), seed=1, options=options) as brain:
    recorder = brain.add_sink(SpikeRecorder(), np.arange(8), name="all")
    brain.run_until(5_000_000)
    saved, weights = brain.snapshot(), brain.read_weights("p").tolist()
    for label, weight in (("p", 3.0), ("q", 0.2)):
        brain.run_until(brain.now_ns + 5_000_000)
        brain.set_weights(label, weight)
    brain.restore(saved)
    brain.run_until(15_000_000)
    spikes = recorder.spikes()
    print(json.dumps([spikes.neurons.tolist(), [*spikes.times_ms.tolist(), *weights]]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("program", [
    pytest.param(PROGRAM, id="built in"),
    pytest.param(EQUATIONS.replace("LAZY", "'never'"), id="equations", marks=pytest.mark.heavy),
    pytest.param(
        EQUATIONS.replace("LAZY", "'always'").replace("(leaky, curved)", "(leaky, leaky)"),
        id="lazy equations", marks=pytest.mark.heavy,
    ),
    pytest.param(SNAPSHOT, id="snapshot", marks=pytest.mark.heavy),
])  # fmt: skip
def test_it_computes_the_same(program: str, capsys: pytest.CaptureFixture[str]) -> None:
    exec(program, {})
    neurons, times_ms = json.loads(capsys.readouterr().out)
    assert len(neurons) > 10
    done = subprocess.run(
        [sys.executable, "-W", "error::RuntimeWarning", "-c", program],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, check=True, capture_output=True, text=True,
    )  # fmt: skip
    found = json.loads(done.stdout)
    assert found[0] == neurons
    assert found[1] == pytest.approx(times_ms, abs=1e-12)
