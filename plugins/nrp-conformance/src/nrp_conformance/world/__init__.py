"""The suites for worlds; each contains the one before it."""

from nrp_conformance.world.bodies import BodyTests, JointTests
from nrp_conformance.world.capability import CapabilityTests, RuntimeChangeTests
from nrp_conformance.world.comparison import CrossTests, SpeedTests
from nrp_conformance.world.driving import DrivingTests
from nrp_conformance.world.mechanics import MechanicsTests
from nrp_conformance.world.motion import ExactMotionTests, MotionTests
from nrp_conformance.world.muscles import MuscleTests
from nrp_conformance.world.sensors import CameraTests, SensorTests
from nrp_conformance.world.state import SequenceTests, StateTests
from nrp_conformance.world.topics import TopicTests


class WorldContractTests(TopicTests, MotionTests, DrivingTests, CameraTests, StateTests):
    """The tests for every world."""


class WorldBackendTests(
    WorldContractTests,
    CapabilityTests,
    ExactMotionTests,
    BodyTests,
    JointTests,
    MuscleTests,
    SensorTests,
    RuntimeChangeTests,
    MechanicsTests,
):
    """The tests for the author of a backend: contract, capabilities, accuracy."""


class FullWorldTests(WorldBackendTests, SequenceTests, CrossTests, SpeedTests):
    """All tests: also random sequences, pairs of worlds, and speed."""
