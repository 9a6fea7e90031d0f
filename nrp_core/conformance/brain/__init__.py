"""The suites for brains; each contains the one before it."""

from nrp_core.conformance.brain.accuracy import AccuracyTests, DeviceAccuracyTests
from nrp_core.conformance.brain.capability import CapabilityTests
from nrp_core.conformance.brain.changes import ChangeTests
from nrp_core.conformance.brain.comparison import CrossTests, SpeedTests
from nrp_core.conformance.brain.devices import DeviceTests
from nrp_core.conformance.brain.each import EachTests
from nrp_core.conformance.brain.life import LifeTests
from nrp_core.conformance.brain.precision import PrecisionTests
from nrp_core.conformance.brain.sequences import SequenceTests
from nrp_core.conformance.brain.short_term import ShortTermTests
from nrp_core.conformance.brain.state import StateTests
from nrp_core.conformance.brain.statistical import StatisticalTests
from nrp_core.conformance.brain.timing import TimingTests
from nrp_core.conformance.brain.twins import TwinTests
from nrp_core.conformance.brain.wiring import WiringTests


class BrainContractTests(TimingTests, WiringTests, EachTests, DeviceTests, StateTests, LifeTests):
    """The tests for every brain."""


class BrainBackendTests(
    BrainContractTests,
    CapabilityTests,
    ChangeTests,
    ShortTermTests,
    AccuracyTests,
    DeviceAccuracyTests,
    PrecisionTests,
    TwinTests,
):
    """The tests for the author of a backend: contract, capabilities, accuracy."""


class FullBrainTests(BrainBackendTests, SequenceTests, StatisticalTests, CrossTests, SpeedTests):
    """All tests: also random sequences, distributions, pairs of brains, and speed."""
