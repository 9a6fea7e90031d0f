"""What every brain of the platform must do, from the platform's own kit."""

import pytest
from nrp_conformance import BrainBackendTests


class _OnPyNN(BrainBackendTests):
    backend_name = "pynn"


@pytest.mark.slow
@pytest.mark.simulator("neuron")
class TestNeuron(_OnPyNN):
    """pyNN.neuron."""

    options = {"simulator": "neuron"}  # noqa: RUF012


@pytest.mark.heavy  # it interprets each step; NEURON by the same driver is tested in each run
@pytest.mark.simulator("brian2")
class TestBrian2(_OnPyNN):
    """pyNN.brian2."""

    options = {"simulator": "brian2"}  # noqa: RUF012
