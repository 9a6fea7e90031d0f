"""The conformance kit: one suite for any brain and one for any world, using only their interfaces.

Three lines in the tests of a backend run it::

    from nrp_conformance import BrainBackendTests

    class TestMine(BrainBackendTests):
        backend_name = "mine"

or, once it is installed, by ``nrp conformance brain mine``. The kit needs pytest and hypothesis.
"""

import pytest

pytest.register_assert_rewrite("nrp_conformance.brain", "nrp_conformance.world")

from nrp_conformance.base import BackendTests  # noqa: E402
from nrp_conformance.brain import BrainBackendTests, BrainContractTests, FullBrainTests  # noqa: E402
from nrp_conformance.brain.comparison import CrossTests as BrainCrossTests  # noqa: E402
from nrp_conformance.world import FullWorldTests, WorldBackendTests, WorldContractTests  # noqa: E402
from nrp_conformance.world.comparison import CrossTests as WorldCrossTests  # noqa: E402

SUITES: dict[str, dict[str, type[BackendTests]]] = {
    "brain": {"contract": BrainContractTests, "core": BrainBackendTests, "full": FullBrainTests},
    "world": {"contract": WorldContractTests, "core": WorldBackendTests, "full": FullWorldTests},
}
"""The suites by kind of backend and level; each level contains the one before it."""

__all__ = [
    "SUITES",
    "BrainBackendTests",
    "BrainContractTests",
    "BrainCrossTests",
    "FullBrainTests",
    "FullWorldTests",
    "WorldBackendTests",
    "WorldContractTests",
    "WorldCrossTests",
]
