"""Notes about calls that mean nothing here, each given once."""

from __future__ import annotations

import logging
from functools import cache

log = logging.getLogger("hbp_nrp_virtual_coach")


@cache
def say_once(message: str) -> None:
    """Log a warning, unless it has been logged before."""
    log.warning(message)
