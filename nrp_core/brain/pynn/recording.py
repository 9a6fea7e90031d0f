"""PyNN's recording calls, which a script may make while it builds."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

from pyNN import recording

from nrp_core.errors import NetworkError

if TYPE_CHECKING:
    from nrp_core.brain.pynn.simulator import Simulator


class Recorder(recording.Recorder):
    """Stores the variables to record; there are no data before the network runs."""

    _simulator: Simulator

    def _record(self, variable: Any, new_ids: set[Any], sampling_interval: float | None = None) -> None:
        """Do nothing."""

    def _reset(self) -> None:
        """Do nothing: there are no data."""

    def _clear_simulator(self) -> None:
        """Do nothing: there are no data."""

    def get(self, *_: Any, **__: Any) -> NoReturn:
        """Raise an error: the network has not run."""
        raise NetworkError(
            f"population '{self.population.label}' has no data: a brain script builds the network, the "
            "experiment runs it; take out what reads data"
        )

    count = get
