"""The numbers that can be changed during a run: parameters of cells, weights, constants of functions."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite
from typing import Any, Final

import numpy as np

from nrp_cockpit.session.constants import Number, constants_of
from nrp_cockpit.session.live import LiveSession
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.network.cells import CELLS
from nrp_core.network.data import Population

_MV: Final = 20.0
"""Width of half a slider of a potential, mV."""


class Parameters:
    """The parameters of the cells of a run, and the constants of its transfer functions.

    Args:
        session: the session, whose run may be exchanged.
    """

    def __init__(self, session: LiveSession) -> None:
        self._session = session

    def read(self, population: str | None = None, index: int | None = None) -> dict[str, Any]:
        """Return the numbers by ``functions`` (files) and ``populations``, or those of one cell alone.

        Raises:
            ExperimentError: the cell does not exist.
        """
        files = [] if population is not None else [
            {"file": file, "numbers": [asdict(one.number) for one in constants_of(file, text)]}
            for file, text in self._session.functions.texts.items()
        ]  # fmt: skip
        populations = self._session.run.brain.network.populations if population is None else [population]
        return {
            "functions": [each for each in files if each["numbers"]],
            "populations": [
                {"population": label, "index": index, "numbers": self._of_cells(label, index)}
                for label in populations
            ],
        }

    def set_cells(self, population: str, name: str, value: float, index: int | None = None) -> None:
        """Change a parameter of a population, or of one cell of it.

        Raises:
            CapabilityError: the brain cannot change it while it runs.
            NetworkError: the cell or parameter does not exist, or the value is impossible.
        """
        self._session.run.set_parameters(population, {name: value}, None if index is None else [index])

    def set_weights(self, projection: str, weight: float) -> None:
        """Give all synapses of a projection the same weight.

        Raises:
            CapabilityError: the brain cannot change it while it runs.
            NetworkError: the projection does not exist, or the weight is impossible.
        """
        self._session.run.set_weights(projection, weight)

    def scale_weights(self, projection: str, factor: float) -> None:
        """Multiply the present weights of a projection; raises the errors of :meth:`set_weights`."""
        self._session.run.set_weights(projection, factor, relative=True)

    def set_constant(self, file: str, name: str, value: float) -> dict[str, Any]:
        """Change a constant of a file as an unchecked edit does; return what :meth:`.Functions.apply` does.

        Raises:
            ExperimentError: the constant does not exist, or the value is not finite.
        """
        text = self._session.functions.texts.get(file, "")
        found = {one.number.name: one for one in constants_of(file, text)}
        if name not in found:
            raise ExperimentError(f"{file} has no constant '{name}'{did_you_mean(name, found)}")
        if not isfinite(value):
            raise ExperimentError(f"a constant is a finite number, not {value}")
        edited = {file: found[name].with_value(text, value)}
        return self._session.functions.apply(edited, check=False)

    def _of_cells(self, label: str, index: int | None) -> list[dict[str, Any]]:
        now = self._session.run.brain.read_parameters(label)
        population = self._session.run.brain.network.populations[label]
        cells = slice(None) if index is None else slice(index, index + 1)
        if index is not None and not 0 <= index < population.size:
            raise ExperimentError(f"the cells of '{label}' are 0 to {population.size - 1}, not {index}")
        return [asdict(_of_cell_type(population, name, values, cells)) for name, values in now.items()]


def _of_cell_type(population: Population, name: str, values: Any, cells: slice) -> Number:
    """Return a parameter of cells; its slider begins and ends around its value at time 0."""
    least, most = float(np.min(values[cells])), float(np.max(values[cells]))
    usual = float(np.mean(population.parameters[name][cells]))
    declared = CELLS[population.cell_type].parameters.get(name) if population.cell_type in CELLS else None
    unit = declared.unit if declared else ""
    half = _MV if unit == "mV" else abs(usual) or 1.0
    return Number(name, least if least == most else None, usual - half, usual + half, note=unit)
