"""Serves the page of a sweep and follows its folder."""

from __future__ import annotations

from pathlib import Path

from nrp_cockpit.session.controls import prefixed, validated
from nrp_cockpit.session.requests import Requests
from nrp_cockpit.sweep.sheet import Sheet
from nrp_cockpit.wire.hub import Hub, Service
from nrp_core.errors import NrpError

TOPIC = "/cockpit/sweep"
_LOOK_S = 1.0
"""Wall time between two looks at the folder, s."""


class SweepSession:
    """Shows a sweep to clients.

    Args:
        folder: the folder of the sweep.
        hub: of the clients.

    Raises:
        ExperimentError: the folder does not contain a sweep.
    """

    def __init__(self, folder: Path, hub: Hub) -> None:
        self._sheet, self._hub, self._requests = Sheet(folder), hub, Requests()
        hub.offer_json(TOPIC)
        hub.services = prefixed(
            {}, {"sweep/runs": self._asked(self._sheet.runs), "sweep/figure": self._asked(self._sheet.figure)}
        )

    def serve(self) -> None:
        """Tell clients of the sweep and answer them until :meth:`close` or Ctrl-C."""
        self._requests.serve(self._tell, _LOOK_S, self._follow)

    def close(self) -> None:
        """End :meth:`serve`; any thread may call this."""
        self._requests.close()

    def play(self) -> None:
        """Do nothing: the runs have ended, or go on in another process."""

    def _follow(self) -> None:
        """Send new results. A file that is being replaced is read at the next poll."""
        try:
            if self._sheet.update():
                self._tell()
        except (NrpError, OSError):
            return

    def _tell(self) -> None:
        self._hub.send_json(TOPIC, self._sheet.data())

    def _asked(self, service: Service) -> Service:
        """Return a service that is called in the thread of :meth:`serve`: Matplotlib belongs to one."""
        checked = validated(service)
        return lambda **fields: self._requests.ask(lambda: checked(**fields))
