"""NEST's kernel, one in each process: its start and its owner."""

from __future__ import annotations

import os
from typing import Any, Final

from nrp_core.brain import Grid, ProcessLock, flushing_subnormals

NAME: Final = "NEST"
_DEFAULT_DELAY_MS: Final = 1.0
"""Default delay of NEST's synapse models, which must be in the range of delays."""


class Kernel:
    """Ownership of NEST's kernel, until it is released or garbage collected.

    Args:
        grid: NEST's time grid.
        threads: number of threads for the neurons.

    Raises:
        LifecycleError: the kernel has another owner.
    """

    def __init__(self, grid: Grid, threads: int) -> None:
        self._right = ProcessLock(NAME)
        self._grid, self._threads = grid, threads
        self._nest = import_nest()

    def start(self, longest_delay_ms: float) -> Any:
        """Empty the kernel and return the module ``nest``, at time 0.

        Args:
            longest_delay_ms: the range of delays must be known before the first step, because devices
                may connect later.
        """
        nest, step_ms = self._nest, self._grid.step_ms
        nest.ResetKernel()
        nest.verbosity = nest.VerbosityLevel.ERROR
        with flushing_subnormals():  # for threads that begin here
            nest.local_num_threads = self._threads
        nest.resolution = step_ms
        nest.set(min_delay=step_ms, max_delay=max(_DEFAULT_DELAY_MS, longest_delay_ms))
        return nest

    def release(self) -> None:
        """Release the kernel."""
        self._nest.ResetKernel()
        self._right.release()


def import_nest() -> Any:
    """Return the module ``nest``, without its banner."""
    os.environ.setdefault("PYNEST_QUIET", "1")  # NEST prints a banner on standard output
    import nest

    return nest
