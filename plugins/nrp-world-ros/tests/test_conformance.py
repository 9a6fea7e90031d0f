"""What every world of the platform must do, from the platform's own kit."""

import pytest
from nrp_conformance import WorldBackendTests
from nrp_conformance.proof import Proof
from nrp_core.errors import CapabilityError

from conftest import DOMAIN, needs_ros2


@needs_ros2
@pytest.mark.slow
@pytest.mark.usefixtures("no_idle_bodies")
class TestRos(WorldBackendTests):
    """ROS 2, with a body that MuJoCo simulates, against the kit."""

    backend_name = "ros"
    options = {"body": "mujoco", "domain": DOMAIN}  # noqa: RUF012


def test_the_kit_applies_to_a_body_that_is_simulated_and_not_to_a_real_one() -> None:
    report = Proof("world", "ros", {"body": "mujoco"}, "contract").report([])
    assert report.capabilities["own_scene"] is False
    with pytest.raises(CapabilityError, match="'ros'"):
        Proof("world", "ros", {}, "contract").report([])
