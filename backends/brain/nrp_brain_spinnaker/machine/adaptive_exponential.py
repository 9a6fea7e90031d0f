"""The adaptive exponential membrane (Brette & Gerstner 2005, J Neurophysiol 94:3637), in fixed point.

Not part of the machine's software. The exponential current is held over a step, as conductances are, so
steps are short; therefore decays have 32 bits and the adaptation current is kept as 1024 times its value.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.exponential import exp_accum
from nrp_brain_spinnaker.machine.fixed_point import ONE, mul, scale, wrap
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_brain_spinnaker.machine.spiking import note_spike
from nrp_core._support.jit import jit

_STEEPEST: Final = 8 * ONE
"""Maximum argument of the exponential; it suffices to cross any threshold in one step."""


@jit
def update_adaptive(cells: Cells, population: int) -> None:
    """Advance a population by a (sub-)step."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    state, constants = cells.state, cells.constants
    for i in range(first, last):
        v, w = state[kinds.V, i], state[kinds.W, i]
        above = wrap(v - constants[kinds.V_REST, i])
        settled_w = mul(constants[kinds.ADAPTATION, i], above)
        state[kinds.W, i] = wrap(settled_w + scale(wrap(w - settled_w), constants[kinds.ADAPTATION_DECAY, i]))
        if state[kinds.REFRACTORY, i] > 0:
            state[kinds.REFRACTORY, i] -= 1
        else:
            steepness = mul(wrap(v - constants[kinds.V_SOFT, i]), constants[kinds.INVERSE_SLOPE, i])
            spike = mul(constants[kinds.SLOPE, i], exp_accum(min(steepness, _STEEPEST)))
            driven = mul(wrap(cells.drive[i] - (w >> 10)), constants[kinds.R_MEMBRANE, i])
            settled = wrap(constants[kinds.V_REST, i] + driven + spike)
            v = wrap(settled + scale(wrap(v - settled), constants[kinds.MEMBRANE_DECAY, i]))
        if v >= constants[kinds.V_THRESH, i]:
            v = constants[kinds.V_RESET, i]
            state[kinds.W, i] = wrap(state[kinds.W, i] + constants[kinds.ADAPTATION_JUMP, i])
            state[kinds.REFRACTORY, i] = constants[kinds.T_REFRACTORY, i]
            note_spike(cells, i)
        state[kinds.V, i] = v
