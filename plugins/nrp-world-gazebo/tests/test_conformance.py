"""The whole conformance suite, where Gazebo is; ``scripts/gazebo test`` runs it."""

import pytest
from nrp_conformance import FullWorldTests
from nrp_world_gazebo import GazeboBackend

pytestmark = [pytest.mark.heavy, pytest.mark.usefixtures("gazebo")]


class TestGazebo(FullWorldTests):
    backend_name = "gazebo"

    @classmethod
    def make_backend(cls) -> GazeboBackend:
        return GazeboBackend()
