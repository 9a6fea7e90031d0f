"""The service that saves a recording as one HTML file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from nrp_cockpit.session.controls import prefixed, validated
from nrp_cockpit.sharing.sharing import shared_file
from nrp_cockpit.wire.hub import Services
from nrp_core.errors import LifecycleError


def with_sharing(services: Services, recorded: Callable[[], Path | None]) -> Services:
    """Return services, including the one that makes the file.

    Args:
        services: the others.
        recorded: returns the folder of the recording, or None before it exists.
    """

    def share() -> dict[str, Any]:
        folder = recorded()
        if folder is None:
            raise LifecycleError("there is no recording yet: record a part of the run")
        shared = shared_file(folder)
        return {"name": f"{folder.absolute().name}.html", "html": shared.html, "losses": shared.losses}

    return services | prefixed({"share": validated(share)}, {})
