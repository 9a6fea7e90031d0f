"""The backends that ship with the core pass the conformance kit, as anybody's would."""

from __future__ import annotations

from nrp_conformance import BrainBackendTests, WorldBackendTests
from nrp_conformance.brain.state import SequenceTests as BrainSequenceTests
from nrp_conformance.world.state import SequenceTests as WorldSequenceTests


class TestEvent(BrainBackendTests):
    backend_name = "event"


class TestSpinnaker(BrainBackendTests):
    backend_name = "spinnaker"


class TestMujoco(WorldBackendTests):
    backend_name = "mujoco"


class TestPybullet(WorldBackendTests):
    backend_name = "pybullet"


class TestEventSequences(BrainSequenceTests):
    backend_name = "event"


class TestSpinnakerSequences(BrainSequenceTests):
    backend_name = "spinnaker"


class TestMujocoSequences(WorldSequenceTests):
    backend_name = "mujoco"
