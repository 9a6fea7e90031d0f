"""NEST's kernel, of which a process has one: whose it is, and how it starts."""

from __future__ import annotations

import os
import weakref
from typing import Any, Final

from nrp_core.errors import LifecycleError

from nrp_brain_nest.grid import Grid

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

    _holder: weakref.ref[Kernel] | None = None

    def __init__(self, grid: Grid, threads: int) -> None:
        if Kernel._holder is not None and Kernel._holder() is not None:
            raise LifecycleError(
                "NEST has one kernel in a process and another brain is using it; close that brain first, "
                "or give this one a process of its own with the option python, e.g. python: python3"
            )
        self._grid, self._threads = grid, threads
        self._nest = _imported()
        Kernel._holder = weakref.ref(self)

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
        Kernel._holder = None


def _imported() -> Any:
    os.environ.setdefault("PYNEST_QUIET", "1")  # NEST greets on standard output, which is not ours
    import nest

    return nest
