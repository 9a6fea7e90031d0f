"""The suites for worlds; each contains the one before it."""

from pkgutil import iter_modules

import pytest

pytest.register_assert_rewrite(*(f"{__name__}.{module.name}" for module in iter_modules(__path__)))

from nrp_conformance.world.bodies import BodyTests, JointTests  # noqa: E402
from nrp_conformance.world.capability import CapabilityTests, RuntimeChangeTests  # noqa: E402
from nrp_conformance.world.comparison import SpeedTests, WorldCrossTests  # noqa: E402
from nrp_conformance.world.driving import DrivingTests  # noqa: E402
from nrp_conformance.world.mechanics import MechanicsTests  # noqa: E402
from nrp_conformance.world.motion import ExactMotionTests, MotionTests  # noqa: E402
from nrp_conformance.world.muscles import MuscleTests  # noqa: E402
from nrp_conformance.world.own_scene import FullOwnSceneTests as FullOwnSceneTests  # noqa: E402
from nrp_conformance.world.own_scene import OwnSceneTests as OwnSceneTests  # noqa: E402
from nrp_conformance.world.sensors import CameraTests, SensorTests  # noqa: E402
from nrp_conformance.world.state import SequenceTests, StateTests  # noqa: E402
from nrp_conformance.world.topics import TopicTests  # noqa: E402


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


class FullWorldTests(WorldBackendTests, SequenceTests, WorldCrossTests, SpeedTests):
    """All tests: also random sequences, pairs of worlds, and speed."""
