"""Serves the start page, and the session that the user chooses there."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any, Protocol

from nrp_cockpit.session.controls import prefixed, validated
from nrp_cockpit.session.requests import Requests
from nrp_cockpit.start.gallery import Entry, gallery
from nrp_cockpit.start.pictures import Pictures
from nrp_cockpit.wire.hub import Hub
from nrp_core.errors import ExperimentError, did_you_mean

TOPIC = "/cockpit/start"
_REST_S = 1.0


class Served(Protocol):
    """The interface of a served page: a session or a sweep."""

    def play(self) -> None: ...

    def serve(self) -> None: ...

    def close(self) -> None: ...


Open = Callable[[str, Hub, ExitStack], Served]
"""Opens what has a name for the clients of a hub; the stack closes it."""


class StartSession:
    """Shows the gallery, serves the session that a client chooses, and shows the gallery again after it.

    Args:
        hub: of the clients.
        opened: opens a choice.
        folder: the folder whose contents are shown.
    """

    def __init__(self, hub: Hub, opened: Open, folder: Path = Path()) -> None:
        self._hub, self._opened, self._folder = hub, opened, folder
        self._requests = Requests()
        self._chosen: tuple[Served, Hub, ExitStack] | None = None
        self._entries: dict[str, Entry] = {}
        self._pictures = Pictures()
        self._is_left = False
        hub.offer_json(TOPIC)
        hub.constant = prefixed(
            {"start/open": self._asked(self.open)},
            {"start/look": self._asked(self.look), "start/picture": validated(self.picture)},
        )

    def serve(self) -> None:
        """Answer clients and serve their choices until :meth:`close` or Ctrl-C."""
        self._requests.serve(self.look, _REST_S, self._serve_chosen)

    def close(self) -> None:
        """End :meth:`serve`; any thread may call this."""
        self._requests.close()
        self._pictures.close()

    def play(self) -> None:
        """Do nothing, because no run is open."""

    def look(self) -> None:
        """Send clients the present gallery."""
        found = gallery(self._folder)
        self._entries = {entry.name: entry for entry in found}
        folder = str(self._folder.absolute())
        self._hub.send_json(TOPIC, {"folder": folder, "entries": [asdict(entry) for entry in found]})

    def open(self, name: str) -> None:
        """Open an entry; clients see it after this call.

        Raises:
            ExperimentError: it is not on the page, or cannot be opened.
        """
        self._shown(name)
        hub = Hub()
        with ExitStack() as stack:
            self._chosen = self._opened(name, hub, stack), hub, stack.pop_all()

    def picture(self, name: str, *, reads_files: bool = False) -> dict[str, Any]:
        """Return the picture of an experiment, see :meth:`.Pictures.data`; any thread may call this.

        Args:
            name: the experiment.
            reads_files: whether the user agrees that the robots and images of an experiment in the folder are
                read. Nothing is executed. Installed experiments need no consent.

        Raises:
            ExperimentError: it is not on the page, has no picture, or needs consent.
        """
        entry = self._shown(name)
        if not entry.picture:
            raise ExperimentError(f"'{name}' has no picture")
        if not (entry.installed or reads_files):
            raise ExperimentError(f"the files of '{name}' are read for a picture only with 'reads_files'")
        return self._pictures.data(name if entry.installed else str(self._folder / name), entry.picture)

    def _shown(self, name: str) -> Entry:
        if name not in self._entries:
            raise ExperimentError(f"the page does not show '{name}'{did_you_mean(name, self._entries)}")
        return self._entries[name]

    def _serve_chosen(self) -> None:
        if self._chosen is None:
            return
        session, hub, stack = self._chosen

        def leave() -> None:
            self._is_left = True
            session.close()

        self._chosen, self._is_left = None, False
        hub.offer_json(TOPIC)
        hub.send_json(TOPIC, {"folder": str(self._folder.absolute()), "entries": None})
        hub.constant = prefixed({"start/leave": leave}, {})
        self._hub.hand_over(hub)
        with stack:
            session.serve()
        if not self._is_left:
            self.close()
            return
        self.look()
        hub.hand_over(self._hub)

    def _asked(self, method: Callable[..., None]) -> Callable[..., None]:
        """Return a service that is called in the thread of :meth:`serve`."""
        checked = validated(method)
        return lambda **fields: self._requests.ask(lambda: checked(**fields))
