"""All that the compiled code works on."""

from __future__ import annotations

from typing import NamedTuple

from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.ring import Ring, Rows
from nrp_brain_spinnaker.machine.stdp import StdpRows
from nrp_brain_spinnaker.machine.tsodyks_markram import TsodyksRows
from nrp_core._support.jit import borrowed, jit


class Machine(NamedTuple):
    """The arrays of a network on the machine."""

    cells: Cells
    ring: Ring
    static: Rows
    dynamic: TsodyksRows
    plastic: StdpRows


@jit
def lend(machine: Machine) -> Machine:
    """Return all arrays without a share in their memory; counting shares takes most of a short tick."""
    cells, ring, static, dynamic, plastic = machine
    return Machine(
        Cells(
            borrowed(cells.populations), borrowed(cells.constants), borrowed(cells.state),
            borrowed(cells.synapse_constants), borrowed(cells.synapse_state), borrowed(cells.current),
            borrowed(cells.ids), borrowed(cells.arrived), borrowed(cells.value), borrowed(cells.drive),
            borrowed(cells.fired), borrowed(cells.n_fired),
        ),
        Ring(borrowed(ring.slots), borrowed(ring.device), borrowed(ring.saturated)),
        Rows(borrowed(static.start), borrowed(static.line), borrowed(static.weight), borrowed(static.delay)),
        TsodyksRows(
            borrowed(dynamic.start), borrowed(dynamic.line), borrowed(dynamic.weight),
            borrowed(dynamic.delay), borrowed(dynamic.parameters), borrowed(dynamic.state), dynamic.step,
        ),
        StdpRows(
            borrowed(plastic.start), borrowed(plastic.first), borrowed(plastic.rule),
            borrowed(plastic.last_tick), borrowed(plastic.trace), borrowed(plastic.line),
            borrowed(plastic.weight), borrowed(plastic.delay), borrowed(plastic.rules),
            borrowed(plastic.decays), borrowed(plastic.rule_of), borrowed(plastic.history_count),
            borrowed(plastic.history_tick), borrowed(plastic.history_trace),
        ),
    )  # fmt: skip
