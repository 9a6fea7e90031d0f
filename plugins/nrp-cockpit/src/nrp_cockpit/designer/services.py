"""The services of the designer."""

from __future__ import annotations

from pathlib import Path

from nrp_cockpit.designer.designer import Designer, methods_of
from nrp_cockpit.session.controls import validated
from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.wire.calls import PREFIX
from nrp_cockpit.wire.hub import Services

_DESIGNER = f"{PREFIX}designer/"


def with_designer(services: Services, session: LiveSession, file: Path | None = None) -> Services:
    """Return the services of a session with those of its designer.

    Raises:
        ExperimentError: the file cannot be read.
    """
    steering, watching = methods_of(Designer(session, file))
    return Services(
        {**services.steering, **{_DESIGNER + name: validated(call) for name, call in steering.items()}},
        {**services.watching, **{_DESIGNER + name: validated(call) for name, call in watching.items()}},
    )
