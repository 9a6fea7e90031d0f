"""What every world of the platform must do, from the platform's own kit."""

import os

import pytest
from nrp_core.conformance import WorldBackendTests

from conftest import needs_ros2


@needs_ros2
@pytest.mark.slow
@pytest.mark.usefixtures("no_idle_bodies")
class TestRos(WorldBackendTests):
    """ROS 2, with a body that MuJoCo simulates, against the kit."""

    backend_name = "ros"
    options = {"body": "mujoco", "domain": 100 + os.getpid() % 100}  # noqa: RUF012
