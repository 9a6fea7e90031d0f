"""The simulator that PyNN's classes refer to: a name, a state, and the classes bound to it.

In PyNN the simulator is a module. Here it is an object, so that one process can build several networks
side by side.
"""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn, Protocol

import numpy as np
from pyNN import recording
from pyNN.common.control import DEFAULT_TIMESTEP, BaseState

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.errors import NetworkError
from nrp_core.network.changes import Synapses
from nrp_core.seeds import Seeds


class Recorder(recording.Recorder):
    """Stores the variables to record; the network has no data before it runs."""

    _simulator: Simulator

    def _record(self, variable: Any, new_ids: set[Any], sampling_interval: float | None = None) -> None:
        """Do nothing."""

    def _reset(self) -> None:
        """Do nothing: the network has no data."""

    def _clear_simulator(self) -> None:
        """Do nothing: the network has no data."""

    def get(self, *_: Any, **__: Any) -> NoReturn:
        """Raise an error: the network has not run."""
        raise NetworkError(
            f"population '{self.population.label}' has no data: a brain script builds the network, the "
            "experiment runs it; take out what reads data"
        )

    count = get


class CurrentSource(Protocol):
    """A current source that a network can represent."""

    def steps(self) -> Any:
        """Return the times at which the current changes, ms, and the currents from then on, nA."""


@dataclass(frozen=True, slots=True)
class Injection:
    """A current source and the cells (global ids) that it drives."""

    source: CurrentSource
    cells: IntArray


class State(BaseState):
    """The objects that a script has built so far, and its arguments of ``setup``.

    Args:
        seeds: the family of all random streams that the script does not seed itself.

    Attributes:
        hints_by_cell: a script's hints on how a machine places the populations of each cell class.
        dt: the script's time step, ms.
        default_delay: the delay of synapses for which the script gives none, ms.
        t: current time, ms; it does not advance while building.
        uses_pynn07: whether the script uses spellings of PyNN 0.7, whose results have other forms.
    """

    mpi_rank = 0
    num_processes = 1
    uses_pynn07 = False

    def __init__(self, seeds: Seeds) -> None:
        super().__init__()
        self._seeds = seeds
        self._unnamed_streams = 0
        self.clear()
        self.configure(DEFAULT_TIMESTEP, "auto", "auto")

    def clear(self) -> None:
        """Discard the network."""
        self.populations: list[Any] = []
        self.projections: list[Any] = []
        self.injections: list[Injection] = []
        self.sources: list[CurrentSource] = []
        self.recorders: set[Any] = set()
        self.write_on_end: list[Any] = []
        self.remarks: list[str] = []
        self.hints_by_cell: dict[type, dict[str, float]] = {}
        self.segment_counter = -1
        self.reset()

    def configure(self, timestep: float, min_delay: float | str, max_delay: float | str) -> None:
        """Store the arguments of ``setup``, all in ms; a delay may be ``auto``."""
        self.dt = float(timestep)
        self._min_delay = None if isinstance(min_delay, str) else float(min_delay)
        self.default_delay = self.dt if self._min_delay is None else self._min_delay
        self.max_delay = np.inf if isinstance(max_delay, str) else float(max_delay)

    def reset(self) -> None:
        """Go back to time 0."""
        self.running = False
        self.t = 0.0
        self.t_start = 0.0
        self.segment_counter += 1

    def remark(self, text: str) -> None:
        """Add a sentence about a difference between the network and its description."""
        self.remarks.append(text)

    def before_change(self) -> None:
        """Called before the structure of the network changes."""

    def before_parameters(self, population: Any, index: IntArray, values: Mapping[str, Any]) -> None:
        """Called before parameters of cells change."""

    def before_synapses(self, projection: Any, values: Mapping[str, FloatArray]) -> None:
        """Called before parameters of synapses change."""

    def weights_of(self, projection: Any) -> FloatArray:
        """Return the current weights of a projection."""
        weights: FloatArray = projection.values["weight"]
        return weights

    def synapse_state_of(self, projection: Any, name: str) -> FloatArray:
        """Return a state variable of synapses; before the network runs the one at time 0."""
        equations = getattr(projection.synapse_type, "equations", None)
        initial = 0.0
        if equations is not None and name in equations.model.variables:
            initial = equations.model.initial[name] / equations.model.variables[name].unit.scale
        return np.full(len(projection), initial)

    def synapses_of(self, projection: Any) -> Synapses | None:
        """Return the current synapses of a projection whose synapses form and vanish; None before a run."""
        return None

    def inject(self, source: CurrentSource, cells: IntArray) -> None:
        """Inject a current into cells (global ids).

        Raises:
            CapabilityError: the network cannot represent the current.
        """
        source.steps()
        self.injections.append(Injection(source, cells))

    def injected(self) -> list[CurrentSource]:
        """Return the source of each injected current."""
        return [injection.source for injection in self.injections]

    def current_data(self, source: CurrentSource) -> tuple[FloatArray, FloatArray]:
        """Raise an error: the network has not run."""
        raise NetworkError(f"{type(source).__name__} has no data: a brain script builds the network")

    def run_until(self, t_ms: float) -> None:
        """Raise an error: the experiment runs the network, not its script."""
        raise NetworkError(
            f"a brain script builds the network, the experiment runs it: take out what runs it to {t_ms:g} ms"
        )

    @property
    def min_delay(self) -> float:
        """The smallest delay, ms: from ``setup``, or else the smallest delay of the synapses."""
        if self._min_delay is not None:
            return self._min_delay
        delays = [
            projection.values.extremes("delay").min()
            for projection in self.projections
            if len(projection) and "delay" in projection.values
        ]
        return float(min(delays, default=self.dt))

    @property
    def n_cells(self) -> int:
        """Number of cells so far, which is the global id of the next."""
        return sum(population.size for population in self.populations)

    def stream(self, name: str | None = None) -> np.random.RandomState:
        """Return the random stream of a name; without a name, the next unnamed stream."""
        if name is None:
            name = f"unnamed/{self._unnamed_streams}"
            self._unnamed_streams += 1
        return np.random.RandomState(self._seeds.stream(name).bit_generator)


@dataclass(eq=False)
class Simulator:
    """One network under construction.

    Args:
        state: the network.
        name: the simulator's name in recorded data.
        types: PyNN's classes bound to this simulator, by name.
    """

    state: State
    name: str = "nrp-core"
    types: dict[str, Any] = field(default_factory=dict)

    def bind(self, base: type, name: str | None = None) -> type:
        """Return a subclass whose objects belong to this simulator.

        Args:
            base: the base class.
            name: its name in ``types``; by default the name of the base class.
        """
        bound = type(base.__name__, (base,), {"_simulator": self, "__doc__": base.__doc__})
        self.types[name or base.__name__] = bound
        return bound
