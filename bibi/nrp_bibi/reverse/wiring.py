"""The connections of Python transfer functions, read from their decorators without execution."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from nrp_bibi.reverse.expressions import dotted_name
from nrp_bibi.reverse.imported import imported, with_full_names
from nrp_bibi.reverse.refusal import NotExpressibleError

_SENDS = ("nrp.MapRobotPublisher", "nrp.Neuron2Robot", "nrp.Robot2Neuron")
_TOPICS = ("nrp.MapRobotSubscriber", *_SENDS)
_DEVICES = ("nrp.MapSpikeSource", "nrp.MapSpikeSink", "nrp.NeuronMonitor")
_BRAIN = "nrp.brain."
_GROUP = "group"


@dataclass(frozen=True, slots=True)
class Connection:
    """A connection of a function.

    Args:
        function: the name of the function.
        variable: the name of its argument; empty: its return value.
        target: the topic, or the name of the neurons in the brain.
        kind: the type of the topic's messages, or of the device, with dots.
        is_topic: whether it is a topic; otherwise it is a device.
        is_written: whether the function sends the message or drives the neurons.
        neurons: which neurons, such as ``actors[0]``; empty for a topic.
        is_pattern: whether ``target`` has placeholders in braces, from an f-string.
    """

    function: str
    variable: str
    target: str
    kind: str
    is_topic: bool
    is_written: bool
    neurons: str = ""
    is_pattern: bool = False


def connections(code: str) -> list[Connection]:
    """Return the connections of all functions in a text, including those in loops; none if it is not Python.

    A name that the text computes, other than by an f-string, gives no connection.
    """
    try:
        tree = ast.parse(code)
    except (SyntaxError, ValueError):
        return []
    names = imported(tree)
    values = {
        node.targets[0].id: node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    }
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    return [
        found
        for function in functions
        for decorator in function.decorator_list
        for found in _of(function.name, with_full_names(_with_neurons(decorator, values), names))
    ]


def _with_neurons(decorator: ast.expr, values: Mapping[str, ast.expr]) -> ast.expr:
    """Return a decorator with the neurons that an assignment gives a name in place of the name."""
    match decorator:
        case ast.Call(func=func, args=[first, ast.Name(id=name), *rest], keywords=keywords) if name in values:
            return ast.Call(func, [first, values[name], *rest], keywords)
    return decorator


def _of(function: str, decorator: ast.expr) -> Iterator[Connection]:
    """Yield the connection that a decorator makes, if it is one."""
    if not isinstance(decorator, ast.Call):
        return
    try:
        name = dotted_name(decorator.func)
    except NotExpressibleError:
        return
    match decorator.args:
        case [ast.Constant(value=str(variable)), topic] if name in _TOPICS:
            yield from _topic(function, variable, topic, is_written=name in _SENDS)
        case [topic] if name in _TOPICS:
            yield from _topic(function, "", topic, is_written=True)
        case [ast.Constant(value=str(variable)), neurons, kind] if name in _DEVICES:
            yield from _device(function, variable, neurons, kind, is_written=name == "nrp.MapSpikeSource")
        case [neurons, kind] if name in _DEVICES:
            yield from _device(function, function, neurons, kind, is_written=False)


def _topic(function: str, variable: str, node: ast.expr, *, is_written: bool) -> Iterator[Connection]:
    match node:
        case ast.Call(func=ast.Name(id="Topic"), args=[address, kind, *_]):
            is_pattern = isinstance(address, ast.JoinedStr)
            text = _address(address)
            if text is not None:
                yield Connection(
                    function, variable, text, ast.unparse(kind), True, is_written, is_pattern=is_pattern
                )


def _address(node: ast.expr) -> str | None:
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(map(_part, parts))
    return None


def _part(node: ast.expr) -> str:
    return (
        f"{{{ast.unparse(node.value)}}}" if isinstance(node, ast.FormattedValue) else ast.literal_eval(node)
    )


def _device(
    function: str, variable: str, neurons: ast.expr, kind: ast.expr, *, is_written: bool
) -> Iterator[Connection]:
    text = ast.unparse(neurons)
    chosen = (ast.unparse(node) for node in ast.walk(neurons) if isinstance(node, ast.Attribute))
    named = (one.removeprefix(_BRAIN) for one in chosen if one.startswith(_BRAIN))
    for population in dict.fromkeys(name.partition(".")[0] for name in named):
        if population == _GROUP:
            continue  # its name is computed
        yield Connection(
            function, variable, population, ast.unparse(kind).removeprefix("nrp."), False, is_written,
            neurons=text.removeprefix(_BRAIN) if text.startswith(_BRAIN) else population,
        )  # fmt: skip
