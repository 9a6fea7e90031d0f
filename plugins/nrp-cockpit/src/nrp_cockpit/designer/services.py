"""The services of a live session, including those of its designer."""

from __future__ import annotations

from pathlib import Path

from nrp_cockpit.designer.designer import Designer, methods_of
from nrp_cockpit.session.controls import prefixed, services_of, validated
from nrp_cockpit.session.opening import Opening, with_opening
from nrp_cockpit.sharing.services import with_sharing
from nrp_cockpit.wire.hub import Services


def offer_services(opening: Opening, file: Path | None = None) -> None:
    """Offer all services of a session, and offer them again for each new run.

    Args:
        opening: opens runs for the session.
        file: the file that the designer opens first; None: the first existing model of the experiment.

    Raises:
        ExperimentError: the file cannot be read.
    """
    session, designer = opening.session, Designer(opening, file)

    def offer() -> None:
        services = with_sharing(with_opening(services_of(session), opening), lambda: session.recorded_path)
        session.hub.services = _with_designer(services, designer)

    opening.on_exchange = offer
    offer()


def _with_designer(services: Services, designer: Designer) -> Services:
    of_designer = (
        {f"designer/{name}": validated(call) for name, call in each.items()} for each in methods_of(designer)
    )
    return services | prefixed(*of_designer)
