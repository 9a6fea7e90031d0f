"""The suites for brains; each contains the one before it."""

from pkgutil import iter_modules

import pytest

pytest.register_assert_rewrite(*(f"{__name__}.{module.name}" for module in iter_modules(__path__)))

from nrp_conformance.brain.accuracy import AccuracyTests, DeviceAccuracyTests, PrecisionTests  # noqa: E402
from nrp_conformance.brain.capability import CapabilityTests, ChangeTests, ShortTermTests  # noqa: E402
from nrp_conformance.brain.comparison import BrainCrossTests, SpeedTests, StatisticalTests  # noqa: E402
from nrp_conformance.brain.devices import DeviceTests  # noqa: E402
from nrp_conformance.brain.equivalence import EquivalenceTests  # noqa: E402
from nrp_conformance.brain.state import SequenceTests, StateTests  # noqa: E402
from nrp_conformance.brain.timing import LifecycleTests, TimingTests  # noqa: E402
from nrp_conformance.brain.voltages import VoltageTests  # noqa: E402
from nrp_conformance.brain.wiring import CellTests, WiringTests  # noqa: E402


class BrainContractTests(TimingTests, WiringTests, CellTests, DeviceTests, StateTests, LifecycleTests):
    """The tests for every brain."""


class BrainBackendTests(
    BrainContractTests,
    CapabilityTests,
    ChangeTests,
    ShortTermTests,
    AccuracyTests,
    DeviceAccuracyTests,
    PrecisionTests,
    VoltageTests,
    EquivalenceTests,
):
    """The tests for the author of a backend: contract, capabilities, accuracy."""


class FullBrainTests(BrainBackendTests, SequenceTests, StatisticalTests, BrainCrossTests, SpeedTests):
    """All tests: also random sequences, distributions, pairs of brains, and speed."""
