"""PyNN's complete API as a module bound to one network under construction."""

from __future__ import annotations

import argparse
import difflib
import functools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from math import isfinite, isnan
from numbers import Real
from types import MappingProxyType, ModuleType
from typing import Any, Final, NoReturn

import numpy as np
from pyNN import common, connectors, errors, random, space, standardmodels
from pyNN.network import Network as Components
from pyNN.standardmodels import StandardCellType

from nrp_core._support.checked_arguments import is_number
from nrp_core.clock import from_milliseconds, nanoseconds
from nrp_core.errors import BackendError, NetworkError, did_you_mean
from nrp_core.network.cells import CELLS
from nrp_core.network.pynn import electrodes, models, populations, projections, rng, synapses
from nrp_core.network.pynn.arguments import InvalidValueError, PastTimeError, WrongKindError, refuse_misspelt
from nrp_core.network.pynn.composed_cells import composed_cells
from nrp_core.network.pynn.connectors import connector_types
from nrp_core.network.pynn.equation_cells import cells_in_equations
from nrp_core.network.pynn.equation_models import (
    SYNAPSES,
    equation_cell,
    equation_synapse,
    nestml_cell,
    registered_synapse,
)
from nrp_core.network.pynn.export import network_of
from nrp_core.network.pynn.simulator import Recorder, Simulator
from nrp_core.network.synapses import LAWS
from nrp_core.parameters import GivenParameters

_MOST_CALLS: Final = 1000
"""At one time; a callback may name the present time some times, as one with a list of times does."""


class Callback:
    """A callback whose answers let a run advance.

    Args:
        function: returns the time (ms) at which it is to be called next.
        until_ms: the end of the run, after which the answers are not read.
    """

    def __init__(self, function: Callable[[float], Any], until_ms: float) -> None:
        self._function, self._until_ns = function, from_milliseconds(until_ms)
        self._called_ns, self._calls = -1, 0

    def __call__(self, now_ms: float) -> Any:
        """Call it.

        Raises:
            InvalidValueError: the answer is no time, or the present or a past one again and again.
        """
        answer, now_ns = self._function(now_ms), from_milliseconds(now_ms)
        self._calls = self._calls + 1 if now_ns == self._called_ns else 1
        self._called_ns = now_ns
        is_time = isinstance(answer, Real) and not isnan(answer) and nanoseconds(float(answer)) >= now_ns
        if now_ns < self._until_ns and (not is_time or self._calls > _MOST_CALLS):
            name = getattr(self._function, "__name__", self._function)
            raise InvalidValueError(
                f"run: the callback {name} returned {answer!r:.40} at {now_ms:g} ms; it must return the time "
                "of its next call, after the present one"
            )
        return answer


def checked(functions: Sequence[Callable[[float], Any]] | None, until_ms: float) -> list[Callback] | None:
    """Return callbacks of a run until a time, ms, with their answers checked.

    Raises:
        WrongKindError: they are not a list of functions.
    """
    if functions is None:
        return None
    given = [*functions] if isinstance(functions, Iterable) else [None]
    if not all(map(callable, given)):
        raise WrongKindError(
            f"run: callbacks are a list of functions, which are called with the time, not {functions!r:.60}"
        )
    return [Callback(function, until_ms) for function in given] or None


NAME = "nrp_core.pynn"
SIMULATOR_NAME = "nrp"
"""The simulator name that scripts see."""

_SETTINGS = frozenset({"timestep", "min_delay", "max_delay", "backend", "seed", "options"})
"""The arguments of ``setup`` that are known here; those of other simulators are ignored."""
_ALIKE = 0.75

_BOUND = (
    populations.Population, populations.PopulationView, populations.Assembly, projections.Projection,
    electrodes.DCSource, electrodes.ACSource, electrodes.StepCurrentSource, electrodes.NoisyCurrentSource,
    rng.NumpyRNG, rng.NativeRNG, rng.RandomDistribution,
)  # fmt: skip
_UNBOUND = (
    Components, StandardCellType, random.GSLRNG, space.Space, space.Line, space.Grid2D, space.Grid3D,
    space.RandomStructure, space.Cuboid, space.Sphere,
)  # fmt: skip


def programming_interface(
    simulator: Simulator,
    recorder: type = Recorder,
    parameters: Mapping[str, object] = MappingProxyType({}),
) -> ModuleType:
    """Return a module with every name of a PyNN simulator.

    Not part of PyNN: ``network()`` returns a :class:`~nrp_core.network.data.Network`, ``parameter``
    declares a :class:`~nrp_core.parameters.Parameter`, ``EquationCell`` and ``EquationSynapse`` make types of
    equations, ``nestml_cell`` one of a file of NESTML.

    Args:
        simulator: the simulator that the module belongs to.
        recorder: the class that stores the recordings of populations.
        parameters: the values of parameters; others have their defaults.
    """
    api = ModuleType(NAME, "A PyNN simulator that builds a network as data.")
    simulator.bind(recorder, "Recorder")
    bound = (*_BOUND, *synapses.synapse_types(), *connector_types())
    simulator.types.update(models.cell_types())
    names: dict[str, Any] = {
        **{name: simulator.types[name] for name in CELLS},
        **cells_in_equations(),
        **composed_cells(),
        **models.rule_parts(),
        "EquationCell": equation_cell,
        "EquationSynapse": _bound_synapse(simulator),
        "nestml_cell": nestml_cell,
        **models.unavailable_models(),
        **{unbound.__name__: unbound for unbound in _UNBOUND},
        **{base.__name__: simulator.bind(base) for base in bound},
        **_control(simulator),
        **_procedures(simulator),
        "native_cell_type": models.native_model("cell type", list(CELLS)),
        "native_synapse_type": models.native_model("synapse type", [law.pynn for law in LAWS.values()]),
        "list_standard_models": lambda: [*CELLS, *cells_in_equations()],
        "parameter": GivenParameters(parameters).parameter,
        "network": lambda: network_of(simulator.state),
        "get_simulator": lambda *arguments: (api, _defaults(arguments)),
        "get_script_args": _script_arguments,
        "simulator": simulator,
        "state": simulator.state,
        "errors": errors,
    }
    names["Neuromodulation"] = synapses.neuromodulation(simulator)
    modules = {module.__name__.rpartition(".")[2]: module for module in (random, space, connectors)}
    names.update({name: overlaid(module, names) for name, module in modules.items()})
    names["standardmodels"] = overlaid(standardmodels, names)
    for part in ("cells", "electrodes", "receptors", "synapses"):
        setattr(names["standardmodels"], part, overlaid(getattr(standardmodels, part), names))
    api.__dict__.update(names, __getattr__=_others(api, simulator))
    return api


def _bound_synapse(simulator: Simulator) -> Callable[..., type]:
    """Return :func:`equation_synapse` with results that belong to a simulator, whose delays they have."""

    @functools.wraps(equation_synapse)
    def bound_synapse(*texts: Any, **arguments: Any) -> type:
        return _bound(equation_synapse(*texts, **arguments), simulator)

    return bound_synapse


def _bound(law: type, simulator: Simulator) -> type:
    """Return a synapse type of equations whose synapses have the shortest delay of a simulator by default."""
    return type(law.__name__, (law,), {"_simulator": simulator, "__doc__": law.__doc__})


def overlaid(module: ModuleType, names: Mapping[str, Any]) -> ModuleType:
    """Return a copy of one of PyNN's modules, with its names replaced by those in ``names``."""
    copy = ModuleType(module.__name__, module.__doc__)
    own = {name: value for name, value in vars(module).items() if not name.startswith("__")}
    copy.__dict__.update({name: names.get(name, value) for name, value in own.items()})
    return copy


def _control(simulator: Simulator) -> dict[str, Any]:
    state = simulator.state

    def setup(
        timestep: float = common.control.DEFAULT_TIMESTEP, min_delay: float | str = "auto", **extra: Any
    ) -> int:
        """Discard the network and start again; times in ms."""
        if not (isinstance(timestep, (int, float, np.number)) and timestep > 0):
            raise NetworkError(f"setup: the time step must be more than 0 ms, not {timestep}")
        refuse_misspelt("setup", "setting", extra, _SETTINGS, _ALIKE)
        longest = extra.get("max_delay", "auto")
        if isinstance(longest, (int, float, np.number)) and not longest >= timestep:
            raise NetworkError(
                f"setup: max_delay ({longest:g} ms) must be at least the time step ({timestep:g} ms)"
            )
        try:
            common.setup(timestep, min_delay, **extra)
        except Exception as error:  # noqa: BLE001 - PyNN has errors of its own for invalid times
            raise NetworkError(f"setup: {error}") from None
        state.clear()
        state.configure(timestep, min_delay, longest)
        return state.mpi_rank

    def end(compatible_output: bool = True) -> None:
        """Do nothing: the network has no data before it runs."""

    advance = common.build_run(simulator)[1]

    def run_until(time_point: float, callbacks: Any = None) -> float:
        """Run to a time (ms), see PyNN.

        Raises:
            PastTimeError: the time has passed.
        """
        _require_time(time_point)
        if time_point - state.t < -state.dt / 2:
            raise PastTimeError(f"run: {time_point:g} ms is in the past; the time is {state.t:g} ms")
        reached: float = advance(time_point, checked(callbacks, time_point))
        return reached

    def run(simtime: float, callbacks: Any = None) -> float:
        """Run for a time (ms), see PyNN."""
        _require_time(simtime)
        return run_until(state.t + simtime, callbacks)

    queries = ("get_current_time", "get_time_step", "get_min_delay", "get_max_delay", "num_processes", "rank")
    return {
        "setup": setup,
        "end": end,
        "run": run,
        "run_for": run,
        "run_until": run_until,
        "reset": common.build_reset(simulator),
        **dict(zip(queries, common.build_state_queries(simulator), strict=True)),
    }


def _procedures(simulator: Simulator) -> dict[str, Any]:
    types = simulator.types
    record = common.build_record(simulator)
    return {
        "create": common.build_create(types["Population"]),
        "connect": common.build_connect(
            types["Projection"], types["FixedProbabilityConnector"], types["StaticSynapse"]
        ),
        "set": common.set,
        "initialize": common.initialize,
        "record": record,
        "record_v": lambda source, filename: record(["v"], source, filename),
        "record_gsyn": lambda source, filename: record(["gsyn_exc", "gsyn_inh"], source, filename),
    }


def _require_time(time_ms: Any) -> None:
    if not is_number(time_ms):
        raise WrongKindError(f"run: the time is a number of ms, not {time_ms!r:.60}")
    if not isfinite(time_ms):
        raise NetworkError(f"run: the time must be finite, not {time_ms:g} ms")


class _NoArguments(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise NetworkError(f"a brain script gets no command line: {message}")


def _defaults(arguments: tuple[Any, ...]) -> argparse.Namespace:
    """Return the result of PyNN's ``get_simulator`` for a command line with only a simulator.

    Raises:
        WrongKindError: an argument is not one of a command line.
    """
    for given in arguments:
        if not isinstance(given, list | tuple) or len(given) < 2:
            raise WrongKindError(
                "get_simulator: its arguments are (name, help) of further ones of the command line, not "
                f"{given!r:.60}; the simulator is named on the command line, here it is this one"
            )
    parser = _NoArguments()
    parser.add_argument("simulator")
    for name, text, *options in arguments:
        parser.add_argument(name, help=text, **(options[0] if options else {}))
    return parser.parse_args([SIMULATOR_NAME])


def _script_arguments(n_args: int, usage: str = "") -> list[str]:
    if n_args > 1:
        raise NetworkError(f"a brain script gets no command line; it asks for {n_args} arguments {usage}")
    return [SIMULATOR_NAME][:n_args]


def _others(api: ModuleType, simulator: Simulator) -> Callable[[str], Any]:
    """Return a function for the names that a module lacks: synapse types of packages, imported if used."""

    def attribute(name: str) -> Any:
        if name == "__all__":
            return [*_public(api), *_usable()]
        if name in SYNAPSES.names():
            vars(api)[name] = law = _bound(registered_synapse(name), simulator)
            return law
        close = difflib.get_close_matches(name, [*vars(api), *SYNAPSES.names()], 1)
        raise AttributeError(f"PyNN has no '{name}'{did_you_mean(name, close) if close else ''}")

    return attribute


def _public(module: ModuleType) -> list[str]:
    return [name for name in vars(module) if not name.startswith("_")]


def _usable() -> Iterator[str]:
    """Yield the synapse types of packages that can be imported, for a script that imports all names."""
    for name in SYNAPSES.names():
        with suppress(BackendError):
            registered_synapse(name)
            yield name
