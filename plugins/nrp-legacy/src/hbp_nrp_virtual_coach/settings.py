"""Settings of runs from environment variables, because scripts were not written for them."""

from __future__ import annotations

import logging
import os
from functools import cache
from pathlib import Path

from nrp_core.cli.options import overrides_of

log = logging.getLogger("hbp_nrp_virtual_coach")


@cache
def say_once(message: str) -> None:
    """Log a warning, unless it has been logged before."""
    log.warning(message)


REAL_TIME = "realtime"
"""The default pace: scripts wait for times of the clock on the wall."""


def overrides() -> list[str]:
    """Return the settings in the variables of ``nrp run``: models, backends, seed, pace and other values."""

    def value(name: str) -> str | None:
        return os.environ.get(name) or None

    models = [Path(folder) for folder in (value("NRP_MODELS") or "").split(os.pathsep) if folder]
    return overrides_of(
        (value("NRP_SET") or "").split(),
        brain=value("NRP_BRAIN"),
        world=value("NRP_WORLD"),
        models=models,
        seed=value("NRP_SEED"),
        pace=value("NRP_PACE") or REAL_TIME,
    )
