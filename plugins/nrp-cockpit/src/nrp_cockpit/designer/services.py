"""The services of a live session, those of its designer among them."""

from __future__ import annotations

from pathlib import Path

from nrp_cockpit.designer.designer import Designer, methods_of
from nrp_cockpit.session.controls import services_of, validated
from nrp_cockpit.session.opening import Opening, with_opening
from nrp_cockpit.wire.calls import PREFIX
from nrp_cockpit.wire.hub import Services

_DESIGNER = f"{PREFIX}designer/"


def offer_services(opening: Opening, file: Path | None = None) -> None:
    """Offer everything that people can ask of a session, and again for each run that it gets.

    Args:
        opening: opens runs for the session.
        file: what the designer begins with; None: the first model of the experiment that there is.

    Raises:
        ExperimentError: the file cannot be read.
    """
    session, designer = opening.session, Designer(opening, file)

    def offer() -> None:
        session.hub.services = _with_designer(with_opening(services_of(session), opening), designer)

    opening.on_exchange = offer
    offer()


def _with_designer(services: Services, designer: Designer) -> Services:
    steering, watching = methods_of(designer)
    return Services(
        {**services.steering, **{_DESIGNER + name: validated(call) for name, call in steering.items()}},
        {**services.watching, **{_DESIGNER + name: validated(call) for name, call in watching.items()}},
    )
