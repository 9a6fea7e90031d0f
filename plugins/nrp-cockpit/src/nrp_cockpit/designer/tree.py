"""Parts of a model by their paths, such as ``transfer_function/0/device/1``."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from nrp_bibi.generation.expressions import as_python
from nrp_bibi.generation.selectors import selection
from nrp_bibi.model.expressions import FlowExpression
from nrp_bibi.model.metamodel import Feature, Node, Value, features
from nrp_bibi.model.selectors import NeuronGroupSelector, NeuronSelector

from nrp_core.errors import ExperimentError

FUNCTIONS = "transfer_function"
NO_NEURONS = "?"
"""The text of neurons whose population has no name, or none that is valid in Python."""


def at(model: Node, path: str) -> Any:
    """Return the node or nodes at a path.

    Raises:
        ExperimentError: the path does not exist.
    """
    found: Any = model
    for step in _steps(path):
        if isinstance(found, tuple):
            if not (step.isdigit() and int(step) < len(found)):
                raise _nothing(path)
            found = found[int(step)]
        elif isinstance(found, Node) and any(feature.field == step for feature in features(type(found))):
            found = getattr(found, step)
        else:
            raise _nothing(path)
    return found


def replaced(model: Any, path: str, value: Any) -> Any:
    """Return a model with a new value at a path; None removes an item from its list."""
    return _replaced(model, _steps(path), value)


def _replaced(part: Any, steps: list[str], value: Any) -> Any:
    if not steps:
        return value
    first, *rest = steps
    if isinstance(part, tuple):
        place = int(first)
        new = _replaced(part[place], rest, value)
        return (*part[:place], *(() if new is None else (new,)), *part[place + 1 :])
    return replace(part, **{first: _replaced(getattr(part, first), rest, value)})


def parent_of(path: str) -> str:
    """Return the path of the parent."""
    return path.rpartition("/")[0]


def function_of(path: str) -> str:
    """Return the path of the transfer function that contains a part; empty if none does."""
    steps = _steps(path)
    return "/".join(steps[:2]) if steps[:1] == [FUNCTIONS] and len(steps) > 1 else ""


def feature_of(node: Node, field: str) -> Feature:
    """Return a feature of a node.

    Raises:
        ExperimentError: it has no feature of this name.
    """
    for feature in features(type(node)):
        if feature.field == field:
            return feature
    raise ExperimentError(f"a {type(node).__name__} has no '{field}'")


def walk(node: Node, path: str = "") -> Iterator[tuple[str, Node]]:
    """Yield a node and everything below it, each with its path."""
    yield path, node
    for feature in features(type(node)):
        value = getattr(node, feature.field)
        below = f"{path}/{feature.field}" if path else feature.field
        if isinstance(value, Node):
            yield from walk(value, below)
        elif isinstance(value, tuple):
            for place, one in enumerate(value):
                if isinstance(one, Node):
                    yield from walk(one, f"{below}/{place}")


def path_at_line(model: Node, line: int) -> str:
    """Return the path of the innermost part that begins at or before a line."""
    best, first = "", 0
    for path, node in walk(model):
        if first <= node.line <= line:
            best, first = path, node.line
    return best


def node_data(node: Node) -> dict[str, Any]:
    """Return a node with everything below it; expressions and selectors also as Python."""
    fields = {feature.field: _value_data(feature, getattr(node, feature.field))
              for feature in features(type(node))}  # fmt: skip
    return {"type": type(node).__name__, "line": node.line, "text": text_of(node), "fields": fields}


def text_of(node: Node) -> str:
    """Return an expression or selector as Python, without the name of the brain; else an empty text."""
    if isinstance(node, FlowExpression):
        return ast.unparse(as_python(node))
    if isinstance(node, (NeuronSelector, NeuronGroupSelector)):
        try:
            return selection(node).replace("nrp.brain.", "").replace("nrp.", "")
        except SyntaxError:  # the population has no name yet, or none that is valid in Python
            return NO_NEURONS
    return ""


def _value_data(feature: Feature, value: Any) -> Any:
    if feature.many:
        return [_one_data(feature, one) for one in value]
    return None if value is None else _one_data(feature, value)


def _one_data(feature: Feature, value: Any) -> Any:
    return feature.of.show(value) if isinstance(feature.of, Value) else node_data(value)


def _steps(path: str) -> list[str]:
    return path.split("/") if path else []


def _nothing(path: str) -> ExperimentError:
    return ExperimentError(f"the model has no '{path}'")
