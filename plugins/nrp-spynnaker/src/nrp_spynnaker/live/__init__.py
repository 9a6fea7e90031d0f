"""sPyNNaker's simulator, which runs its scripts on the emulated machine."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from math import ceil, isfinite
from numbers import Real
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, Final

import nrp_core.pynn
from nrp_core.errors import ExperimentError
from nrp_core.pynn.runners import run_as_main
from nrp_spynnaker.dialect import Dialect
from nrp_spynnaker.dialect.connections import Hub
from nrp_spynnaker.live.clock import SimulatedClock, stops_elsewhere
from nrp_spynnaker.live.recorder import LabelledRecorder
from nrp_spynnaker.live.state import LiveState

BACKEND: Final = "spinnaker"
OPTIONS: Final[Mapping[str, Any]] = {"semantics": "released"}
"""Cells and weights mean what they mean in sPyNNaker, which differs from PyNN for some cells."""
_ROUNDING: Final = 1e-5
"""Of a time step; a smaller part of one is an error of rounding."""


def run_script(
    path: Path, backend: str | None = None, options: Mapping[str, str] = MappingProxyType({})
) -> ModuleType:
    """Run a script of sPyNNaker as the main program, and return its module.

    ``time.sleep`` in a callback of the script waits for simulated time, so that a run is the same each time.

    Raises:
        NrpError: the script does something impossible; with file and line.
        Exception: whatever else the script raises.
    """
    if backend or options:
        raise ExperimentError("--as spinnaker chooses the backend, so it takes no --backend and no --option")
    clock = SimulatedClock()
    state = LiveState(Hub(), clock, waits=stops_elsewhere(path.read_bytes()))
    pynn = nrp_core.pynn.new_simulator(state, LabelledRecorder)
    vars(pynn)["setup"] = partial(pynn.setup, backend=BACKEND, options=OPTIONS)
    dialect = Dialect(pynn, *_running(pynn, state), state.hub, of_script=True)
    try:
        return run_as_main(path, pynn, dialect, modules=clock.modules())
    finally:
        state.close()


def _running(pynn: ModuleType, state: LiveState) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the names of the simulator, and of its ``external_devices``, that run the network."""
    advance = pynn.run

    def whole_steps(time_ms: Any) -> Any:
        """Return a time in whole steps; sPyNNaker rounds it up, with a warning."""
        if not _is_finite(time_ms):
            return time_ms  # which is refused
        rounded_ms = ceil(time_ms / state.dt - _ROUNDING) * state.dt
        if rounded_ms - time_ms > _ROUNDING * state.dt:
            state.warn([
                f"run: {time_ms:g} ms are not whole time steps of {state.dt:g} ms, and are rounded up to "
                f"{rounded_ms:g} ms"
            ])  # fmt: skip
        return rounded_ms

    def run(
        simtime: float | None = None, _sync_time: float = 0.0, callbacks: Any = None,
        run_time: float | None = None,
    ) -> float | None:  # fmt: skip
        """Run for a time (ms); without one, in real time until it is stopped, beside the script."""
        simtime = run_time if simtime is None else simtime
        if simtime is None:
            state.run_forever()
            return None
        return float(advance(whole_steps(simtime), callbacks))

    def run_until(tstop: float, callbacks: Any = None) -> float:
        """Run to a time (ms)."""
        remains = tstop - state.t if _is_finite(tstop) else tstop
        return run(remains, callbacks=callbacks) or state.t

    def run_forever(_sync_time: float = 0.0) -> None:
        """Run in real time, beside the script, until ``request_stop`` or ``end``."""
        state.run_forever()

    names = {
        "run": run,
        "run_for": run,
        "run_until": run_until,
        "run_forever": run_forever,
        "stop_run": state.stop,
    }
    devices = {"run_forever": run_forever, "request_stop": state.stop}
    return names, devices


def _is_finite(time_ms: Any) -> bool:
    return isinstance(time_ms, Real) and not isinstance(time_ms, bool) and isfinite(time_ms)
