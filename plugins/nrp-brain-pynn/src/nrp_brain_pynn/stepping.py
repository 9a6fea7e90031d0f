"""One long run of Brian2 that pauses at given steps.

Each run of Brian2 prepares everything again, which takes longer than a step of the loop. So one long run is
in a separate thread and pauses at the beginning of a given step. One of the two threads always waits for the
other.
"""

from __future__ import annotations

import threading
from typing import Any, Final

import brian2
from nrp_core.errors import SimulationError

_FOREVER_S: Final = 1e6
"""The longest duration that Brian2 can count in steps of 0.1 ms without rounding."""


class SteppedRun:
    """A run of a Brian2 network.

    Args:
        network: the complete network.
        clock: its only clock.

    Attributes:
        step: number of the next step.
    """

    def __init__(self, network: Any, clock: Any) -> None:
        self._network = network
        self._number = clock.variables["timestep"]
        self._halted, self._go = threading.Semaphore(0), threading.Semaphore(0)
        self._error: BaseException | None = None
        self._stopping = False
        self.step = self._target = 0
        network.add(brian2.NetworkOperation(self._halt, when="start", order=-1, clock=clock))
        self._thread = threading.Thread(target=self._run, name="brian2", daemon=True)
        self._thread.start()
        self._wait()

    def until(self, step: int) -> None:
        """Run to the beginning of a step.

        Raises:
            SimulationError: Brian2 failed.
        """
        self._target = step
        self._go.release()
        self._wait()
        self.step = step

    def stop(self) -> None:
        """End the run."""
        if self._thread.is_alive():
            self._stopping = True
            self._go.release()
            self._thread.join()

    def _wait(self) -> None:
        self._halted.acquire()
        if self._error is not None:
            raise SimulationError(f"Brian2 failed: {self._error}") from self._error

    # -- in the thread of the run

    def _run(self) -> None:
        try:
            self._network.run(_FOREVER_S * brian2.second, namespace={})
        except BaseException as error:  # noqa: BLE001  whatever it is, the waiting thread raises it
            self._error = error
        self._halted.release()

    def _halt(self) -> None:
        if int(self._number.get_value()[0]) >= self._target:
            self._halted.release()
            self._go.acquire()
            if self._stopping:
                self._network.stop()
