"""The cells of sPyNNaker: PyNN's with more variables to record, its own, and those that are refused."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from pyNN.parameters import Sequence

from nrp_core.brain.network.cells import CELLS
from nrp_core.brain.pynn.invalid import WrongKindError
from nrp_core.brain.pynn.populations import SPIKE_TIMES

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
    return own | {name: _own(pynn[cell], name, cell) for name, cell in _OWN_NAMES.items()}


def _own(cell: Any, name: str, cell_type: str) -> type:
    """Return a cell type whose arguments may be initial values too, and that records all synaptic input."""
    variables, example = dict(cell.default_initial_values), next(iter(cell.default_parameters))
    in_order = _IN_ORDER.get(name, ())

    def begin(self: Any, *values: Any, **parameters: Any) -> None:
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
