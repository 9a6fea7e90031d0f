"""What every brain of the platform must do, from the platform's own kit."""

from importlib.util import find_spec

import pytest
from nrp_core.conformance import BrainBackendTests


class _OnPyNN(BrainBackendTests):
    backend_name = "pynn"


@pytest.mark.slow
@pytest.mark.skipif(find_spec("nest") is None, reason="NEST is not installed")
class TestNest(_OnPyNN):
    """pyNN.nest."""

    options = {"simulator": "nest"}  # noqa: RUF012


@pytest.mark.slow
@pytest.mark.skipif(find_spec("neuron") is None, reason="NEURON is not installed")
class TestNeuron(_OnPyNN):
    """pyNN.neuron."""

    options = {"simulator": "neuron"}  # noqa: RUF012


@pytest.mark.slow
@pytest.mark.skipif(find_spec("brian2") is None, reason="Brian2 is not installed")
class TestBrian2(_OnPyNN):
    """pyNN.brian2."""

    options = {"simulator": "brian2"}  # noqa: RUF012
