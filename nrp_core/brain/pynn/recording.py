"""PyNN's recording calls, which a script may make while it builds."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

from pyNN import recording

from nrp_core.errors import NetworkError

if TYPE_CHECKING:
    from nrp_core.brain.pynn.simulator import Simulator


class Recorder(recording.Recorder):
    """Notes what shall be recorded; there are no data before the network runs."""

    _simulator: Simulator

    def _record(self, variable: Any, new_ids: set[Any], sampling_interval: float | None = None) -> None:
        """Nothing to prepare."""

    def _reset(self) -> None:
        """Nothing to forget."""

    def _clear_simulator(self) -> None:
        """Nothing to forget."""

    def get(self, *_: Any, **__: Any) -> NoReturn:
        """Refuse: nothing has run."""
        raise NetworkError(
            f"population '{self.population.label}' has no data: a brain script builds the network, the "
            "experiment runs it; take out what reads data"
        )

    count = get
