"""PyNN's functions around a run, for a simulator that runs."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Any

from pyNN.common.control import DEFAULT_MIN_DELAY, DEFAULT_TIMESTEP

from nrp_core.brain.backends import brains
from nrp_core.network.pynn.arguments import require_kind
from nrp_core.pynn.running import DEFAULT_BACKEND, RunningState
from nrp_core.seeds import require_seed


def control(api: ModuleType, state: RunningState) -> Mapping[str, Any]:
    """Return ``setup`` and ``end`` of a simulator that runs its network."""
    begin = api.setup

    def setup(
        timestep: float | None = None,
        min_delay: float | str = DEFAULT_MIN_DELAY,
        *,
        backend: str = DEFAULT_BACKEND,
        options: Mapping[str, Any] | None = None,
        seed: int = 0,
        **extra: Any,
    ) -> int:
        """Discard the network and start again.

        Args:
            timestep: ms; the interval at which state is sampled, and the smallest delay; 0.1 by default. If
                it is given, it is also the step of a backend that has the option ``timestep``.
            min_delay: ms, or ``auto``: the time step.
            backend: name of an installed brain backend.
            options: options of the backend.
            seed: seed of all random numbers that the script does not seed itself.
            extra: ``max_delay``; arguments of other simulators are ignored, as PyNN requires.
        """
        rank: int = begin(DEFAULT_TIMESTEP if timestep is None else timestep, min_delay, **extra)
        require_kind("setup", "backend", backend, str, "the name of a brain backend, such as 'event'")
        require_kind(
            "setup", "options", options, (Mapping, type(None)), "a dictionary such as {'threads': 2}"
        )
        require_seed(seed)
        brains().provider(backend)
        state.use(backend, options or {}, seed, follows=timestep is not None)
        return rank

    def end(**_: Any) -> None:
        """Write the requested data, and release the brain."""
        for population, variables, filename in state.write_on_end:
            population.write_data(filename, variables)
        state.write_on_end = []
        state.end()

    return {"setup": setup, "end": end}
