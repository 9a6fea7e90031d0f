"""The checks, one module for each subject; importing this registers them."""

from nrp_core.checks.subjects import bounds as bounds
from nrp_core.checks.subjects import capabilities as capabilities
from nrp_core.checks.subjects import drives as drives
from nrp_core.checks.subjects import lengths as lengths
from nrp_core.checks.subjects import messages as messages
from nrp_core.checks.subjects import operations as operations
from nrp_core.checks.subjects import sensor_visibility as sensor_visibility
from nrp_core.checks.subjects import side_effects as side_effects
from nrp_core.checks.subjects import start_poses as start_poses
from nrp_core.checks.subjects import time_conditions as time_conditions
from nrp_core.checks.subjects import units as units
from nrp_core.checks.subjects import wiring as wiring
