"""The suites for brains; each contains the one before it."""

from nrp_conformance.brain.accuracy import AccuracyTests, DeviceAccuracyTests, PrecisionTests
from nrp_conformance.brain.capability import CapabilityTests, ChangeTests, ShortTermTests
from nrp_conformance.brain.comparison import CrossTests, SpeedTests, StatisticalTests
from nrp_conformance.brain.devices import DeviceTests
from nrp_conformance.brain.equivalence import EquivalenceTests
from nrp_conformance.brain.state import SequenceTests, StateTests
from nrp_conformance.brain.timing import LifecycleTests, TimingTests
from nrp_conformance.brain.voltages import VoltageTests
from nrp_conformance.brain.wiring import CellTests, WiringTests


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


class FullBrainTests(BrainBackendTests, SequenceTests, StatisticalTests, CrossTests, SpeedTests):
    """All tests: also random sequences, distributions, pairs of brains, and speed."""
