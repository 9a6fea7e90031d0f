"""What every brain of the platform must do, from the platform's own kit."""

import pytest
from nrp_conformance import BrainBackendTests


@pytest.mark.slow
class TestNest(BrainBackendTests):
    """NEST against the kit."""

    backend_name = "nest"
