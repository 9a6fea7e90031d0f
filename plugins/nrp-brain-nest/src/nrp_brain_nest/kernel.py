"""NEST's kernel, of which a process has one: how it starts and whom it is given to."""

from __future__ import annotations

import os
from typing import Any, Final

from nrp_core.brain import Grid, Sole

NAME: Final = "NEST"
_DEFAULT_DELAY_MS: Final = 1.0
"""Of NEST's synapse models, which NEST demands to lie in the range."""


class Kernel:
    """The right to NEST's kernel, until it is released or forgotten.

    Args:
        grid: its.
        threads: that share the neurons.

    Raises:
        LifecycleError: another has the kernel.
    """

    def __init__(self, grid: Grid, threads: int) -> None:
        self._right = Sole(NAME)
        self._grid, self._threads = grid, threads
        self._nest = _imported()

    def start(self, longest_delay_ms: float) -> Any:
        """Empty the kernel and return the module ``nest``, at time 0.

        Args:
            longest_delay_ms: the range of delays must be known before the first step, because devices
                may connect later.
        """
        nest, step_ms = self._nest, self._grid.step_ms
        nest.ResetKernel()
        nest.verbosity = nest.VerbosityLevel.ERROR
        nest.local_num_threads = self._threads
        nest.resolution = step_ms
        nest.set(min_delay=step_ms, max_delay=max(_DEFAULT_DELAY_MS, longest_delay_ms))
        return nest

    def release(self) -> None:
        """Give the kernel to whoever comes next."""
        self._nest.ResetKernel()
        self._right.release()


def _imported() -> Any:
    os.environ.setdefault("PYNEST_QUIET", "1")  # NEST greets on standard output, which is not ours
    import nest

    return nest
