"""Checks of the synapses that transmit voltages: gap junctions and graded release."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from nrp_core.errors import NetworkError
from nrp_core.network.drawing import extremes
from nrp_core.network.equations.model import INPUT
from nrp_core.network.indices import stored_form
from nrp_core.units import AMPERE, SIEMENS, VOLT

VOLTAGE: Final = "v"
"""The state variable that is a cell's voltage, also in equations."""


def require_voltages(where: str, projection: Any, populations: Mapping[str, Any]) -> None:
    """Check that the cells at both ends support synapses that transmit voltages.

    Args:
        where: the projection, for the message.
        projection: a continuous :class:`~nrp_core.network.data.Projection`.
        populations: those of its network, by label.

    Raises:
        NetworkError: a source has no voltage, a target receives no current, or the synapses have a delay.
    """
    pre, post = populations[projection.pre], populations[projection.post]
    both = {pre.label: pre, post.label: post}.values() if projection.is_electrical else ()
    if pre.is_source:
        raise NetworkError(f"{where} transmits the voltage of '{pre.label}', which only emits spikes")
    for cells in both or [pre]:
        if cells.equations is not None and not _has_voltage(cells.equations.model):
            raise NetworkError(
                f"{where} transmits the voltage of '{cells.label}', whose equations have no state variable "
                f"'{VOLTAGE}' in V"
            )
    for cells in both or [post]:
        if cells.equations is not None and INPUT not in cells.equations.model.parameters:
            raise NetworkError(
                f"{where} is a current into '{cells.label}', whose equations have no parameter '{INPUT}'"
            )
    if not projection.is_electrical:
        _require_reversal(where, projection, post)
    if projection.size and (longest := float(extremes(stored_form(projection, "delay_ms")).max())):
        raise NetworkError(f"{where}: {projection.synapse_type} synapses have no delay, not {longest:g} ms")


def _require_reversal(where: str, projection: Any, post: Any) -> None:
    """Check that the weights are currents, or conductances with a known reversal potential."""
    unit, valid = post.weight_unit(projection.receptor), (AMPERE, SIEMENS)
    if unit.dimension not in (valid[:1] if post.equations is not None else valid):
        what = "currents" if post.equations is not None else "currents or conductances"
        raise NetworkError(
            f"{where}: {projection.synapse_type} synapses are {what}; those onto receptor "
            f"'{projection.receptor}' of '{post.label}' are in {unit.text}"
        )


def _has_voltage(model: Any) -> bool:
    return VOLTAGE in model.variables and bool(model.variables[VOLTAGE].unit.dimension == VOLT)
