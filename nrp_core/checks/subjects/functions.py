"""The checks of transfer functions; importing this registers them."""

from nrp_core.checks.subjects import capabilities as capabilities
from nrp_core.checks.subjects import devices as devices
from nrp_core.checks.subjects import wiring as wiring
