"""Networks written in PyNN, on every simulator that is installed."""

import subprocess
import sys
from importlib.util import find_spec

import pytest
from nrp_core.brain import builder, network_of

from nrp_brain_pynn import PyNNBackend
from nrp_brain_pynn.simulators import SIMULATORS

pytest_plugins = ["cases"]  # in tests/shared

COMPILE = "from nrp_brain_pynn.loading import quietly\nwith quietly():\n    import pyNN.neuron"
PROGRAMS = [name for name in SIMULATORS if name != "spinnaker"]  # which is a machine
OPTION = "--simulators"


def pytest_addoption(parser):
    parser.addoption(
        OPTION,
        metavar="NAMES",
        help="the simulators to test (neuron,brian2); by default those that are installed",
    )


def pytest_configure(config):
    """Know the chosen simulators, and let PyNN compile its models for NEURON once, before workers start."""
    given = config.getoption(OPTION)
    installed = [name for name, one in SIMULATORS.items() if find_spec(one.package)]
    config.chosen = given.split(",") if given else installed
    unknown = set(config.chosen) - set(SIMULATORS)
    if unknown:
        raise pytest.UsageError(f"{OPTION}: {', '.join(sorted(unknown))}; there are {', '.join(SIMULATORS)}")
    is_worker = hasattr(config, "workerinput")
    if "neuron" in config.chosen and "neuron" in installed and not is_worker:
        subprocess.run([sys.executable, "-c", COMPILE], check=True)


def pytest_report_header(config):
    return f"simulators: {', '.join(config.chosen)}"


def pytest_generate_tests(metafunc):
    if "simulator" in metafunc.fixturenames:
        marked = [pytest.param(name, marks=pytest.mark.simulator(name)) for name in PROGRAMS]
        metafunc.parametrize("simulator", marked)


def pytest_collection_modifyitems(config, items):
    """Leave out the tests of simulators that are not chosen."""
    left_out = [item for item in items if not is_chosen(item)]
    config.hook.pytest_deselected(items=left_out)
    items[:] = [item for item in items if is_chosen(item)]


def is_chosen(item):
    return all(marker.args[0] in item.config.chosen for marker in item.iter_markers("simulator"))


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
