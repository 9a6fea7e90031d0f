"""The suites for worlds; each contains the one before it."""

from nrp_core.conformance.world.bodies import BodyTests
from nrp_core.conformance.world.capability import CapabilityTests
from nrp_core.conformance.world.changing import ChangingTests
from nrp_core.conformance.world.comparison import CrossTests, SpeedTests
from nrp_core.conformance.world.driving import DrivingTests
from nrp_core.conformance.world.exact_motion import ExactMotionTests
from nrp_core.conformance.world.joints import JointTests
from nrp_core.conformance.world.mechanics import MechanicsTests
from nrp_core.conformance.world.motion import MotionTests
from nrp_core.conformance.world.seeing import SeeingTests
from nrp_core.conformance.world.sensing import SensingTests
from nrp_core.conformance.world.sequences import SequenceTests
from nrp_core.conformance.world.state import StateTests
from nrp_core.conformance.world.topics import TopicTests


class WorldContractTests(TopicTests, MotionTests, DrivingTests, SeeingTests, StateTests):
    """The tests for every world."""


class WorldBackendTests(
    WorldContractTests,
    CapabilityTests,
    ExactMotionTests,
    BodyTests,
    JointTests,
    SensingTests,
    ChangingTests,
    MechanicsTests,
):
    """The tests for the author of a backend: contract, capabilities, accuracy."""


class FullWorldTests(WorldBackendTests, SequenceTests, CrossTests, SpeedTests):
    """All tests: also random sequences, pairs of worlds, and speed."""
