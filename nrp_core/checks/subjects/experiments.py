"""The checks of experiments without their functions; importing this registers them."""

from nrp_core.checks.subjects import drives as drives
from nrp_core.checks.subjects import lengths as lengths
from nrp_core.checks.subjects import sensor_visibility as sensor_visibility
from nrp_core.checks.subjects import start_poses as start_poses
from nrp_core.checks.subjects import time_conditions as time_conditions
from nrp_core.checks.subjects import units as units
from nrp_core.checks.subjects import world_capabilities as world_capabilities
