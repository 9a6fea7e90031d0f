"""The PyNN 0.7 calls of scripts for sPyNNaker 7 and before, and the form of their data."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.brain import FloatArray
from nrp_core.errors import NetworkError
from nrp_core.network.pynn.populations import WRITTEN
from nrp_core.network.pynn.simulator import State
from nrp_spynnaker import pynn07
from nrp_spynnaker.dialect import neo_convertor
from nrp_spynnaker.dialect.plasticity import nearest_pair_rule

SPIKES: Final = object()
"""The variables of a call of `record` that names none; None means that nothing is recorded any more."""
_GSYN: Final = ("gsyn_exc", "gsyn_inh")
_LAST: Final = -1
_TEXTS: Final = (".dat", ".txt", ".ras", ".csv")
"""The suffixes by which the name of a file, without a variable, is known."""


def pynn07_names(own: Mapping[str, Any], state: State) -> dict[str, Any]:
    """Return the classes and functions of sPyNNaker that take the words of PyNN 0.7, too.

    Args:
        own: sPyNNaker's names.
        state: the simulator's state, which remembers whether a script uses such words.
    """
    types = {**own, "STDPMechanism": pynn07.mechanism(own["STDPMechanism"])}
    return {
        **{name: pynn07.connector(own[name]) for name in (*pynn07.CONNECTORS, *_LISTS)},
        **{name: pynn07.dependence(own[name]) for name in _DEPENDENCES},
        "STDPMechanism": types["STDPMechanism"],
        "SpikePairRule": _pair_rule(own["SpikePairRule"]),
        "Projection": pynn07.projection(
            own["Projection"], types, lambda: setattr(state, "uses_pynn07", True)
        ),
        "SynapseDynamics": pynn07.SynapseDynamics,
        "RandomDistribution": pynn07.distribution(own["RandomDistribution"]),
        "NumpyRNG": _generator(own["NumpyRNG"]),
        "set": pynn07.by_name(lambda cells, **values: cells.set(**values)),
        "initialize": pynn07.by_name(lambda cells, **values: cells.initialize(**values)),
        "record": _recording(own["record"], "record"),
        "record_v": _recording(own["record_v"], "record_v"),
        "record_gsyn": _recording(own["record_gsyn"], "record_gsyn"),
    }


_LISTS: Final = ("ArrayConnector", "FromFileConnector", "FromListConnector")
_DEPENDENCES: Final = ("AdditiveWeightDependence", "MultiplicativeWeightDependence")


def _pair_rule(pairs: Any) -> Any:
    """Return the rule of pairs of spikes, which may be that of the nearest ones."""
    nearest_rule = nearest_pair_rule(pairs)

    class SpikePairRule(pairs):
        def __new__(cls, *values: Any, nearest: bool = False, **more: Any) -> Any:
            return nearest_rule(*values, **more) if nearest else super().__new__(cls)

        def __init__(self, *values: Any, nearest: bool = False, **more: Any) -> None:
            super().__init__(*values, **more)

    return SpikePairRule


def _generator(today: type) -> type:
    class NumpyRNG(today):
        def __init__(self, *values: Any, rank: int = 0, num_processes: int = 1, **more: Any) -> None:
            super().__init__(*values, **more)

    return NumpyRNG


def _recording(today: Any, method: str) -> Any:
    """Return a function that records cells to a file, with the variables first or without any."""

    def record(*values: Any, **more: Any) -> None:
        if values and hasattr(values[0], method):
            getattr(values[0], method)(*values[1:], **more)
        else:
            today(*values, **more)

    return record


class Pynn07Cells:
    """Methods of populations and views that record and return data as PyNN 0.7 did."""

    def record(self, variables: Any = SPIKES, to_file: Any = None, *arguments: Any, **options: Any) -> None:
        """Record variables, in version 7 spikes; see :meth:`~pyNN.common.BasePopulation.record`."""
        recorded: Any = super().record
        if variables is SPIKES:
            self._record_as_before("spikes", to_file)
        elif isinstance(variables, str) and Path(variables).suffix in _TEXTS:
            self._record_as_before("spikes", to_file or variables)
        else:
            recorded(variables, to_file, *arguments, **options)

    def record_v(self, to_file: Any = None) -> None:
        """Record the voltage."""
        self._record_as_before("v", to_file)

    def record_gsyn(self, to_file: Any = None) -> None:
        """Record the synaptic inputs."""
        self._record_as_before(list(_GSYN), to_file)

    def _record_as_before(self, variables: Any, file: Any) -> None:
        cells: Any = self
        state = cells._simulator.state
        state.uses_pynn07 = state.uses_pynn07 or variables == "spikes"
        cells.record(variables, None if isinstance(file, str) and _is_text(file) else file or None)
        if isinstance(file, str) and _is_text(file):
            state.uses_pynn07 = True
            state.write_on_end.append((self, variables, file))

    def getSpikes(self, gather: bool = True, compatible_output: bool | None = None) -> Any:  # noqa: N802
        """Return the spikes; in version 7 as rows of cell and time (ms)."""
        return self._data(["spikes"], compatible_output)

    def get_v(self, gather: bool = True, compatible_output: bool | None = None) -> Any:
        """Return the voltage; in version 7 as rows of cell, time (ms) and voltage (mV)."""
        return self._data(["v"], compatible_output)

    def get_gsyn(self, gather: bool = True, compatible_output: bool | None = None) -> Any:
        """Return the synaptic inputs; in version 7 as rows of cell, time (ms), excitation and inhibition."""
        return self._data(list(_GSYN), compatible_output)

    def _data(self, variables: list[str], compatible_output: bool | None) -> Any:
        cells: Any = self
        as_before = cells._simulator.state.uses_pynn07 or compatible_output is not None
        return self._rows(variables) if as_before else cells.get_data(variables)

    def _rows(self, variables: list[str]) -> FloatArray:
        cells: Any = self
        data = cells.get_data(variables)
        run = len(data.segments) + _LAST
        if variables == list(_GSYN):
            return neo_convertor.convert_gsyn(data, data, run)
        return neo_convertor.convert_data(data, variables[0], run)

    def printSpikes(self, file: str, gather: bool = True, compatible_output: bool = True) -> None:  # noqa: N802
        """Write the spikes to a file; as text unless its suffix is one of Neo's."""
        self.write_data(file, "spikes")

    def print_v(self, file: str, gather: bool = True, compatible_output: bool = True) -> None:
        """Write the voltage, see :meth:`printSpikes`."""
        self.write_data(file, "v")

    def print_gsyn(self, file: str, gather: bool = True, compatible_output: bool = True) -> None:
        """Write the synaptic inputs, see :meth:`printSpikes`."""
        self.write_data(file, list(_GSYN))

    def write_data(self, io: Any, variables: Any = "all", *arguments: Any, **options: Any) -> None:
        """Write recorded data to a file, see :meth:`~pyNN.common.BasePopulation.write_data`."""
        written: Any = super().write_data
        if isinstance(io, str) and _is_text(io):
            self._write_text(Path(io), [variables] if isinstance(variables, str) else list(variables))
        else:
            written(io, variables, *arguments, **options)

    def _write_text(self, file: Path, variables: list[str]) -> None:
        """Write rows of the values and the cell, with the header of version 7."""
        cells: Any = self
        if variables not in (["spikes"], ["v"], list(_GSYN)):
            raise NetworkError(
                f"'{file}' is to be a file of text, which holds spikes, v or gsyn, not "
                f"{', '.join(variables)}; for others its suffix is one of {', '.join(WRITTEN)}"
            )
        rows = self._rows(variables)
        values = rows[:, 1:] if variables == ["spikes"] else rows[:, 2:]
        header: dict[str, Any] = {
            "variable": "gsyn" if variables == list(_GSYN) else variables[0],
            "first_index": 0, "last_index": cells.size, "first_id": int(cells.first_id),
            "last_id": int(cells.last_id), "n": len(rows), "size": cells.size,
            "dt": cells._simulator.state.dt,
        }  # fmt: skip
        file.parent.mkdir(parents=True, exist_ok=True)
        head = "\n".join(f"{name} = {value}" for name, value in header.items())
        np.savetxt(file, np.column_stack([values, rows[:, 0]]), "%.10g", "\t", header=head)

    def get_spike_counts(self, gather: bool = True) -> dict[int, int]:
        """Return the number of spikes of each cell by its index in the population, as sPyNNaker does."""
        counted: Any = super().get_spike_counts
        cells: Any = self
        first = int(cells._owner().first_id)
        counts = {cell - first: count for cell, count in counted(gather).items()}
        chosen = np.arange(cells._owner().size)[cells._indices()].tolist()
        return {cell: counts.get(cell, 0) for cell in chosen}


def _is_text(file: str) -> bool:
    return bool(Path(file).suffix) and Path(file).suffix not in WRITTEN
