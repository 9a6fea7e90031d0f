"""The services of a live session; each waits until the thread of the run has done it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.wire.hub import Service, Services
from nrp_core.errors import ExperimentError
from nrp_core.experiment.running.commands import commands_of

PREFIX = "/cockpit/"


def services_of(session: LiveSession) -> Services:
    """Return the services of a session."""
    commands = commands_of(session.run)
    functions, bodies, layout = session.functions, session.bodies, Layout(session)

    def asked(method: Callable[..., Any], doing: str = "") -> Service:
        return lambda **fields: session.ask(lambda: method(**fields), doing)

    def changed(method: Callable[..., Any]) -> Service:
        def call(**fields: Any) -> Any:
            found = method(**fields)
            session.reports.all()
            return found

        return asked(call)

    steering: dict[str, Service] = {
        "play": asked(session.play),
        "pause": asked(session.pause),
        "step": asked(session.step),
        "step_back": asked(session.step_back, "stepping back"),
        "reset": asked(session.reset, "resetting"),
        "pace": asked(session.set_pace),
        "run_to": asked(session.run_to),
        "seek": asked(session.seek, "going there"),
        "snapshot": asked(session.snapshot),
        "restore": asked(lambda id: session.restore(id), "going back to the snapshot"),  # noqa: A006
        "record": asked(session.record),
        "publish": commands["publish"],
        "push": asked(bodies.push),
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
    return Services(
        {PREFIX + name: service for name, service in steering.items()},
        {PREFIX + name: service for name, service in watching.items()},
    )


class Layout:
    """The layout of the page, beside the experiment: ``NAME.cockpit.json``.

    Args:
        session: whose experiment it is.
    """

    def __init__(self, session: LiveSession) -> None:
        path = session.run.experiment.source.place.path
        self._path: Path | None = None if path is None else path.with_suffix(".cockpit.json")

    def load(self) -> dict[str, Any]:
        """Return the layout, or nothing where there is none that can be read."""
        try:
            return {"layout": json.loads(self._path.read_text())} if self._path else {}
        except (OSError, ValueError):
            return {}

    def save(self, layout: dict[str, Any]) -> None:
        """Write the layout.

        Raises:
            ExperimentError: the folder of the experiment cannot be written.
        """
        if self._path is None:
            return
        try:
            self._path.write_text(json.dumps(layout, indent=2) + "\n")
        except OSError as error:
            raise ExperimentError(f"the layout cannot be saved: {error.strerror}", path=self._path) from error
