"""A composite of any two brains is a brain like any other, by the platform's own kit."""

from typing import Any, ClassVar

import pytest
from nrp_conformance import BrainBackendTests
from nrp_conformance.brain import BrainContractTests

EXACT = {"backend": "event"}
GRID = {"backend": "event", "options": {"resolution": "1 ms"}}
SPINNAKER = {"backend": "spinnaker"}
TWO_EXACT: dict[str, Any] = {"parts": {"one": EXACT, "two": EXACT}}
TWO_BACKENDS: dict[str, Any] = {"parts": {"grid": GRID, "spinnaker": SPINNAKER}}


class TestTwoBackendsKeepTheContract(BrainContractTests):
    backend_name = "composite"
    options: ClassVar[dict[str, Any]] = TWO_BACKENDS


@pytest.mark.heavy
class TestTwoParts(BrainBackendTests):
    backend_name = "composite"
    options: ClassVar[dict[str, Any]] = TWO_EXACT


@pytest.mark.heavy
class TestTwoBackends(BrainBackendTests):
    backend_name = "composite"
    options: ClassVar[dict[str, Any]] = TWO_BACKENDS
