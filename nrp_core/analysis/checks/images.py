"""Bounds of colours with which no pixel is found."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any

from nrp_core.analysis.events import Call
from nrp_core.analysis.registry import checks_function
from nrp_core.analysis.shapes import Known
from nrp_core.analysis.study import Examined
from nrp_core.dsl.tf_lib.vision import find_centroid_hsv, wrong_bounds
from nrp_core.findings import Code, Finding, Level


@checks_function(Code.NRP320)
def colors_can_be_found(function: Examined) -> Iterator[Finding]:
    """Look for HSV bounds that no pixel meets, or that are in another scale than OpenCV's."""
    for event in function.events:
        match event:
            case Call(node, Known(callee)) if callee is find_centroid_hsv:
                bounds = [_numbers(function, one) for one in node.args[1:]]
                if len(bounds) == 1 and isinstance(node.args[1], ast.Starred):
                    bounds = bounds[0] or []
                if len(bounds) != 2 or not all(_is_triple(one) for one in bounds):
                    continue
                wrong = wrong_bounds(*bounds)
                if wrong:
                    message = f"no colour is found: {wrong}"
                    yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)


def _numbers(function: Examined, node: ast.expr) -> Any:
    """Return a constant of the file, or written out; None if it is neither."""
    value = node.value if isinstance(node, ast.Starred) else node
    if isinstance(value, ast.Name):
        shape = function.declared.names.get(value.id)
        return shape.value if isinstance(shape, Known) else None
    try:
        return ast.literal_eval(value)
    except (ValueError, TypeError):
        return None


def _is_triple(value: Any) -> bool:
    return isinstance(value, tuple | list) and all(type(one) in (int, float) for one in value)
