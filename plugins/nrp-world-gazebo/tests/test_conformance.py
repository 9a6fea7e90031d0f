"""The whole conformance suite, where Gazebo is; ``scripts/gazebo test`` runs it."""

import os
from shutil import which

import pytest
from nrp_world_gazebo import GazeboBackend

from nrp_core.conformance import WorldBackendTests

pytestmark = [
    pytest.mark.heavy,
    pytest.mark.skipif(
        not (os.environ.get("NRP_GAZEBO_ROOT") or which("gzserver")), reason="there is no Gazebo here"
    ),
]


class TestGazebo(WorldBackendTests):
    @classmethod
    def make_backend(cls) -> GazeboBackend:
        return GazeboBackend()
