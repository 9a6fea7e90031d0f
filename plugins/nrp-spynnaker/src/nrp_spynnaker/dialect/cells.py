"""The cells of sPyNNaker: PyNN's with more variables to record, its own, and sources with variable rates."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from pyNN.parameters import Sequence

from nrp_core.brain import FloatArray
from nrp_core.clock import MS_PER_S
from nrp_core.network.cells import CELLS
from nrp_core.network.pynn.arguments import InvalidValueError, WrongKindError
from nrp_core.network.pynn.populations import SPIKE_TIMES

_NAME = "SpikeSourcePoissonVariable"


def variable_poisson(array: Any) -> type:
    """Return sPyNNaker's type of these sources.

    Args:
        array: the class of PyNN's ``SpikeSourceArray``.
    """

    def begin(self: Any, rates: Any, starts: Any, durations: Any = None) -> None:
        array.__init__(self, spike_times=Sequence([]))
        self.variable = VariableRates(rates, starts, durations)

    doc = "Poisson sources whose rates change at given times."
    return type(_NAME, (array,), {"__init__": begin, "__doc__": doc, "cell_type": "SpikeSourceArray"})


class VariableRates:
    """The rates of a population.

    Args:
        rates, starts, durations: Hz and ms; a list for all cells, or one for each. Without durations the
            last rate stays.
    """

    def __init__(self, rates: Any, starts: Any, durations: Any = None) -> None:
        given = {"rates": rates, "starts": starts, "durations": durations}
        self._given = {name: value for name, value in given.items() if value is not None}
        self.drawn_ms = 0.0

    @property
    def has_end(self) -> bool:
        """Whether there is a last spike."""
        return "durations" in self._given

    def trains(
        self, n: int, random: np.random.RandomState, step_ms: float, until_ms: float = np.inf
    ) -> list[Any]:
        """Return the further spike times of ``n`` cells up to a time; they are at time steps.

        Raises:
            InvalidValueError: the lists do not fit together.
        """
        each = {name: self._of_cells(name, n) for name in self._given}
        window = self.drawn_ms, until_ms
        drawn = [_train(*window, random, *(each[name][cell] for name in each)) for cell in range(n)]
        self.drawn_ms = until_ms
        return [Sequence(np.ceil(times / step_ms) * step_ms) for times in drawn]

    def _of_cells(self, name: str, n: int) -> list[FloatArray]:
        given = self._given[name]
        shared = not np.iterable(given[0]) if len(given) else True
        rows = [given] * n if shared else list(given)
        if len(rows) != n:
            raise InvalidValueError(f"{_NAME}: {name} has {len(rows)} lists for {n} cells")
        found = [np.asarray(row, float) for row in rows]
        if not all(np.isfinite(row).all() and (row >= 0).all() for row in found):
            raise InvalidValueError(f"{_NAME}: {name} has a value that is not a number of 0 or more")
        return found


def _train(
    since_ms: float, until_ms: float, random: np.random.RandomState,
    rates: FloatArray, starts: FloatArray, durations: FloatArray | None = None,
) -> FloatArray:  # fmt: skip
    lasts = np.full(len(starts), np.inf) if durations is None else durations
    if not len(rates) == len(starts) == len(lasts) or (np.diff(starts) < 0).any():
        raise InvalidValueError(
            f"{_NAME}: rates, starts and durations of a cell must be of one length, and starts must ascend"
        )
    ends = np.minimum(np.minimum(starts + lasts, np.append(starts[1:], np.inf)), until_ms)
    begins = np.maximum(starts, since_ms)
    counts = random.poisson(rates * np.maximum(ends - begins, 0.0) / MS_PER_S)
    parts = [random.uniform(a, b, n) for a, b, n in zip(begins, ends, counts, strict=True)]
    return np.sort(np.concatenate([np.empty(0), *parts]))


# mypy: disable-error-code="misc"


_SYNAPTIC: Final = ("gsyn_exc", "gsyn_inh")
"""Its names of the synaptic input of all cells, conductances (uS) and currents (nA) alike."""
_OF_ALL_CELLS: Final = ("rewiring",)
"""What a population of cells with synapses can record besides state variables."""
_OWN_NAMES: Final = {
    "Izhikevich": "IZK_curr_exp",
    "Izhikevich_cond": "IZK_cond_exp",
    "IFCurDelta": "IF_curr_delta",
}
"""Its names of cells, and the cell types that they are."""

IN_EQUATIONS: Final = ("Izhikevich_cond_dual", "IF_curr_dual_exp", "IF_curr_exp_sEMD")
"""Its cells that are given as equations, and not emulated."""
_FORMER: Final = "_init"
"""The end of the names of initial values in version 7, such as ``v_init``."""
_IN_ORDER: Final = {
    "SpikeSourceArray": ("spike_times",),
    "SpikeSourcePoisson": ("rate", "start", "duration"),
}
"""The parameters of its sources that scripts also give without a name."""


def cell_types(pynn: Mapping[str, Any]) -> dict[str, type]:
    """Return sPyNNaker's cell types by its names.

    Args:
        pynn: the names of a PyNN simulator.
    """
    own = {name: _own(pynn[name], name, name) for name in CELLS}
    own |= {name: _own(pynn[name], name, pynn[name].cell_type) for name in IN_EQUATIONS}
    return own | {name: _own(pynn[cell], name, cell) for name, cell in _OWN_NAMES.items()}


def _own(cell: Any, name: str, cell_type: str) -> type:
    """Return a cell type whose arguments may be initial values too, and that records all synaptic input."""
    variables, example = dict(cell.default_initial_values), next(iter(cell.default_parameters))
    in_order = _IN_ORDER.get(name, ())

    def begin(self: Any, *values: Any, **parameters: Any) -> None:
        if len(values) == 1 and isinstance(values[0], Mapping):  # as the parameters of a population
            values, parameters = (), {**values[0], **parameters}
        if len(values) > len(in_order):
            raise WrongKindError(f"{name}: give its parameters by name, such as {name}({example}=...)")
        parameters |= zip(in_order, values, strict=False)
        if SPIKE_TIMES in parameters:
            parameters[SPIKE_TIMES] = ascending(parameters[SPIKE_TIMES])
        for key in variables.keys() & {each.removesuffix(_FORMER) for each in parameters}:
            if (former := f"{key}{_FORMER}") in parameters:
                parameters[key] = parameters.pop(former)
        self.given_state = {key: parameters.pop(key) for key in variables.keys() & parameters.keys()}
        cell.__init__(self, **parameters)

    body: dict[str, Any] = {"__init__": begin, "__doc__": cell.__doc__, "cell_type": cell_type}
    if cell.receptor_types:
        unit = "uS" if cell.conductance_based else "nA"
        body["units"] = {**dict.fromkeys(_SYNAPTIC, unit), **cell.units}
        body["recordable"] = list(dict.fromkeys([*cell.recordable, *_SYNAPTIC, *_OF_ALL_CELLS]))
    return type(name, (cell,), body)


def ascending(times: Any) -> Any:
    """Return spike times of one or of all cells in ascending order, which sPyNNaker does not ask for."""
    if isinstance(times, Sequence):
        return Sequence(np.sort(times.value))
    if not isinstance(times, (list, tuple, range, np.ndarray)):
        return times
    if len(times) and (np.iterable(times[0]) or isinstance(times[0], Sequence)):
        return [ascending(each) for each in times]
    return np.sort(times)


def spike_injector(array: Any) -> type:
    """Return the source cells whose spikes a connection sends while the network runs.

    Args:
        array: the class of PyNN's ``SpikeSourceArray``.
    """

    def begin(
        self: Any, notify: bool = True, database_notify_host: str | None = None,
        database_notify_port_num: int | None = None, database_ack_port_num: int | None = None,  # noqa: ARG001
        **settings: Any,
    ) -> None:  # fmt: skip
        array.__init__(self, spike_times=Sequence([]))
        self.program = (database_notify_port_num, database_notify_host) if notify else None
        self.settings = settings

    doc = "Source cells that emit the spikes which a live connection sends."
    return type(
        "SpikeInjector", (array,), {"__init__": begin, "__doc__": doc, "cell_type": "SpikeSourceArray"}
    )
