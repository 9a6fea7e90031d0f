"""The part of a kernel that chooses how long the sub-step is in which a crossing of the threshold is sought.

A threshold that compares two values, ``v > v_thresh``, has a distance: it changes its sign at the crossing.
It is followed along chords, and an end of the bracket that stays has half the weight (the Illinois method,
Dowell & Jarratt 1971, BIT 11:168), so a few sub-steps find what halving finds in twenty-five. Other
thresholds are sought by halving.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

from nrp_brain_event.equations.expressions import needed, source_of
from nrp_core.brain.network.equations.model import Model

_LEAST: Final = 1e-4
"""The least part of a bracket that a sub-step takes or leaves."""


def begun(model: Model) -> Iterator[str]:
    """Yield the lines for the ``share`` of the bracket, ``between``, that a new sub-step takes."""
    distance = _distance(model)
    yield "share = 0.5"
    if distance is None:
        return
    yield from needed([distance], model)
    yield f"below = {source_of(distance, model)}"
    yield "if between < inf:"
    yield from (f"    {line}" for line in [*_share(), "above *= 0.5"])


def crossed(model: Model) -> Iterator[str]:
    """Yield the lines for the share after a sub-step that crosses."""
    distance = _distance(model)
    if distance is None:
        yield "share = 0.5"
        return
    yield f"above = {source_of(distance, model, 'y_')}"
    yield from _share()
    yield "below *= 0.5"


def _share() -> Iterator[str]:
    yield "share = below / (below - above)"
    yield f"share = min(max(share, {_LEAST!r}), {1.0 - _LEAST!r}) if below < 0.0 < above else 0.5"


def _distance(model: Model) -> ast.expr | None:
    """Return what is negative below the threshold and positive above it."""
    if model.is_random:
        return None
    match model.threshold:
        case ast.Compare(left=left, ops=[ast.Gt() | ast.GtE()], comparators=[right]):
            return ast.BinOp(left, ast.Sub(), right)
        case ast.Compare(left=left, ops=[ast.Lt() | ast.LtE()], comparators=[right]):
            return ast.BinOp(right, ast.Sub(), left)
    return None
