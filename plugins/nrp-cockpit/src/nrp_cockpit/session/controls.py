"""The services of sessions; each waits until the thread of the session has done it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.session.session import Session
from nrp_cockpit.wire.hub import Service, Services
from nrp_core.errors import ExperimentError
from nrp_core.experiment.running.commands import commands_of

PREFIX = "/cockpit/"


def services_of(session: LiveSession) -> Services:
    """Return the services of a run."""
    commands = commands_of(session.run)
    functions, bodies = session.functions, session.bodies
    layout = Layout(session.run.experiment.source.place.path)

    def changed(method: Callable[..., Any]) -> Service:
        def call(**fields: Any) -> Any:
            found = method(**fields)
            session.reports.all()
            return found

        return asked(session, call)

    steering: dict[str, Service] = {
        **going(session),
        "snapshot": asked(session, session.snapshot),
        "restore": asked(session, lambda id: session.restore(id), "going back to the snapshot"),  # noqa: A006
        "record": asked(session, session.record),
        "publish": commands["publish"],
        "push": asked(session, bodies.push),
        "place": changed(bodies.place),
        "functions/apply": changed(functions.apply),
        "functions/revert": changed(functions.revert),
        "functions/save": functions.save,
        "functions/activate": changed(functions.activate),
        "layout/save": layout.save,
    }
    watching: dict[str, Service] = {
        "functions/check": functions.check,
        "functions/complete": functions.complete,
        "layout/load": layout.load,
    }
    return prefixed(steering, watching)


def going(session: Session) -> dict[str, Service]:
    """Return the services with which time goes on, back and elsewhere."""
    return {
        "play": asked(session, session.play),
        "pause": asked(session, session.pause),
        "step": asked(session, session.step),
        "step_back": asked(session, session.step_back, "stepping back"),
        "reset": asked(session, session.reset, "resetting"),
        "pace": asked(session, session.set_pace),
        "run_to": asked(session, session.run_to),
        "seek": asked(session, session.seek, "going there"),
    }


def asked(session: Session, method: Callable[..., Any], doing: str = "") -> Service:
    """Return a service that lets the thread of a session call a method."""
    return lambda **fields: session.ask(lambda: method(**fields), doing)


def prefixed(steering: Mapping[str, Service], watching: Mapping[str, Service]) -> Services:
    """Return services under their full names."""
    return Services(
        {PREFIX + name: service for name, service in steering.items()},
        {PREFIX + name: service for name, service in watching.items()},
    )


class Layout:
    """The layout of the page, beside what it shows: ``NAME.cockpit.json``.

    Args:
        shown: an experiment file or a recording; None: there is nowhere to keep it.
    """

    def __init__(self, shown: Path | None) -> None:
        self._path: Path | None = None if shown is None else shown.with_suffix(".cockpit.json")

    def load(self) -> dict[str, Any]:
        """Return the layout, or nothing where there is none that can be read."""
        try:
            return {"layout": json.loads(self._path.read_text())} if self._path else {}
        except (OSError, ValueError):
            return {}

    def save(self, layout: dict[str, Any]) -> None:
        """Write the layout.

        Raises:
            ExperimentError: the folder cannot be written.
        """
        if self._path is None:
            return
        try:
            self._path.write_text(json.dumps(layout, indent=2) + "\n")
        except OSError as error:
            raise ExperimentError(f"the layout cannot be saved: {error.strerror}", path=self._path) from error
