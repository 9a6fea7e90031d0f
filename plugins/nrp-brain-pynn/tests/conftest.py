"""Networks written in PyNN, on every simulator that is installed."""

from importlib.util import find_spec

import pytest
from nrp_core.brain.pynn import builder
from nrp_core.brain.pynn.export import network_of

from nrp_brain_pynn import PyNNBackend
from nrp_brain_pynn.simulators import SIMULATORS

ALL = [
    pytest.param(
        name, marks=pytest.mark.skipif(find_spec(one.package) is None, reason=f"{one.name} is not installed")
    )
    for name, one in SIMULATORS.items()
    if name != "spinnaker"  # is a machine
]


@pytest.fixture(params=ALL)
def simulator(request):
    """Each simulator in turn."""
    return request.param


@pytest.fixture
def network():
    """Make the network that a function builds with a PyNN simulator."""

    def make(build):
        sim = builder(1)
        sim.setup(timestep=0.1)
        build(sim)
        return network_of(sim.state, {})

    return make


@pytest.fixture
def opened():
    """Open a network on one of the simulators, or another backend; closed at the end of the test."""
    brains = []

    def open_(network, simulator, backend=None, **options):
        backend = backend or PyNNBackend()
        given = {"simulator": simulator} if simulator else {}
        brains.append(backend.open(network, seed=1, options=backend.options(**given, **options)))
        return brains[-1]

    yield open_
    for brain in brains:
        brain.close()
