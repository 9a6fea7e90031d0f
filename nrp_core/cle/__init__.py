"""The closed loop: brain and world step together, then the transfer functions run."""

from __future__ import annotations

from nrp_core.cle.latency import LoopPath
from nrp_core.cle.loop import ClosedLoop, Failure, Hooks
from nrp_core.cle.pacing import AsFastAsPossible, Paced, Pacing, pacing_of

__all__ = ["AsFastAsPossible", "ClosedLoop", "Failure", "Hooks", "LoopPath", "Paced", "Pacing", "pacing_of"]
