"""The loops of this package, compiled."""

from __future__ import annotations

from nrp_core._support.jit import jit
from nrp_core.brain.network.drawing import loops

clipped = jit(loops.clipped)
pairs_among = jit(loops.pairs_among)
place_by = jit(loops.place_by)
