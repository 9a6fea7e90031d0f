"""The PyNN script of a drawn brain, written and read."""

from __future__ import annotations

import ast
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

from nrp_bibi.model.metamodel import Node, Value, concrete, features

from nrp_cockpit.designer.brain.model import (
    INITIAL,
    SIMULATOR,
    Brain,
    CellModel,
    Connector,
    Population,
    Projection,
    SynapseModel,
)

_LONGEST = 100
_UNREADABLE = (ValueError, TypeError, KeyError, AttributeError, StopIteration, RecursionError)
_HEAD = f'''\
"""A brain drawn with ``nrp design``.

It can be edited there again unless this file was changed by hand. Units are PyNN's: mV, ms, nF, uS, nA.
"""

import nrp_core.pynn as {SIMULATOR}
'''


@dataclass(frozen=True, slots=True)
class _Call:
    """A call in Python, in one line if it is short."""

    name: str
    arguments: tuple[tuple[str, Any], ...]

    def text(self, indent: str = "") -> str:
        """Return the call; ``indent`` is that of the line on which it begins."""
        shown = [f"{name}={_text(value, '')}" if name else _text(value, "") for name, value in self.arguments]
        line = f"{self.name}({', '.join(shown)})"
        if len(indent) + len(line) <= _LONGEST and "\n" not in line:
            return line
        inner = indent + "    "
        parts = (f"{inner}{name}=" if name else inner for name, _ in self.arguments)
        lines = (
            f"{part}{_text(value, inner)}," for part, (_, value) in zip(parts, self.arguments, strict=True)
        )
        return "\n".join([f"{self.name}(", *lines, f"{indent})"])


@dataclass(frozen=True, slots=True)
class _Name:
    text: str


def _text(value: Any, indent: str) -> str:
    match value:
        case _Call():
            return value.text(indent)
        case _Name():
            return value.text
        case str():
            return json.dumps(value, ensure_ascii=False)
        case dict():
            return "{" + ", ".join(f"{json.dumps(key)}: {item!r}" for key, item in value.items()) + "}"
        case tuple():
            return f"[{', '.join(map(repr, value))}]"
    return repr(value)


# -- writing


def script_of(brain: Brain) -> str:
    """Return the script of a brain; reading it gives an equal brain."""
    statements = [_Call(f"{SIMULATOR}.setup", (("timestep", brain.timestep),)).text()]
    statements += [f"{one.name} = {_population(one).text()}" for one in brain.population]
    statements += [_projection(one).text() for one in brain.projection]
    return "\n".join([_HEAD, "\n\n".join(statements), ""])


def _population(population: Population) -> _Call:
    initial = {
        feature.field.removeprefix(INITIAL): value
        for feature in features(type(population.cells))
        if feature.field.startswith(INITIAL)
        and (value := getattr(population.cells, feature.field)) is not None
    }
    more = (("initial_values", initial),) if initial else ()
    return _Call(f"{SIMULATOR}.Population", (
        ("", population.size), ("", _call(population.cells)), *more, ("label", population.name),
    ))  # fmt: skip


def _projection(projection: Projection) -> _Call:
    return _Call(f"{SIMULATOR}.Projection", (
        ("", _view(projection.source, projection.source_cells)),
        ("", _view(projection.target, projection.target_cells)),
        ("", _call(projection.connector)),
        ("", _call(projection.synapse)),
        ("receptor_type", projection.receptor.value),
        ("label", projection.name),
    ))  # fmt: skip


def _view(population: str, cells: str | None) -> _Name:
    return _Name(f"{population}[{cells}]" if cells else population)


def _call(node: Node) -> _Call:
    """Return the call that makes a node, without arguments that equal their defaults."""
    arguments: list[tuple[str, Any]] = []
    for feature in features(type(node)):
        value = getattr(node, feature.field)
        default = type(node).__dataclass_fields__[feature.field].default
        if value != default and not feature.field.startswith(INITIAL):
            arguments.append((feature.field, _call(value) if isinstance(value, Node) else value))
    return _Call(f"{SIMULATOR}.{type(node).__name__}", tuple(arguments))


# -- reading


def read_script(text: str) -> Brain | None:
    """Return the brain of a script, with the lines of its parts; None: it is not a script of the designer.

    A script is the designer's if the designer would write exactly the same text, so that no change by hand
    can get lost.
    """
    try:
        brain = _read(ast.parse(text))
    except (SyntaxError, *_UNREADABLE):
        return None
    return brain if script_of(brain) == text else None


def reason_against(text: str) -> tuple[str, int | None]:
    """Return why a text is not a script of the designer, and on which line."""
    try:
        wanted = script_of(_read(ast.parse(text))).splitlines()
    except SyntaxError as error:
        return f"this is not Python: {error.msg}", error.lineno
    except _UNREADABLE:
        return "the designer cannot draw this", None
    found = text.splitlines()
    for number, (one, other) in enumerate(zip_longest(found, wanted), 1):
        if one != other:
            return f"the designer would write {other or 'nothing'!r} here", number
    return "the last line has no line break", len(found)


def _read(tree: ast.Module) -> Brain:
    timestep, populations, projections = 0.0, [], []
    for statement in tree.body[2:]:  # after the docstring and the import
        match statement:
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Call() as call):
                populations.append(_read_population(name, call))
            case ast.Expr(value=ast.Call(func=ast.Attribute(attr="Projection")) as call):
                projections.append(_read_projection(call))
            case ast.Expr(value=ast.Call(func=ast.Attribute(attr="setup")) as call):
                timestep = float(_keywords(call)["timestep"])
    return Brain(timestep=timestep, population=tuple(populations), projection=tuple(projections), line=1)


def _read_population(name: str, call: ast.Call) -> Population:
    size, cells = call.args
    initial = _keywords(call).get("initial_values", {})
    more = {INITIAL + variable: value for variable, value in initial.items()}
    return Population(
        name=_checked(Population, "name", name),
        size=_checked(Population, "size", ast.literal_eval(size)),
        cells=_read_node(cells, CellModel, more),
        line=call.lineno,
    )


def _read_projection(call: ast.Call) -> Projection:
    source, target, connector, synapse = call.args
    given = _keywords(call)
    ends = {}
    for side, end in (("source", source), ("target", target)):
        population, _, cells = ast.unparse(end).partition("[")
        ends[side] = _checked(Projection, side, population)
        ends[f"{side}_cells"] = _checked(Projection, f"{side}_cells", cells.rstrip("]")) if cells else None
    return Projection(
        name=_checked(Projection, "name", given["label"]),
        receptor=_checked(Projection, "receptor", given["receptor_type"]),
        connector=_read_node(connector, Connector),
        synapse=_read_node(synapse, SynapseModel),
        line=call.lineno,
        **ends,
    )


def _read_node(call: ast.expr, base: type[Node], more: Mapping[str, Any] | None = None) -> Any:
    """Return the node that a call makes, of a subclass of ``base``."""
    if not isinstance(call, ast.Call) or call.args:
        raise ValueError
    kind = concrete(base)[ast.unparse(call.func).removeprefix(f"{SIMULATOR}.")]
    of = {feature.field: feature.of for feature in features(kind)}
    given: dict[str, Any] = {}
    for argument in call.keywords:
        part = of[str(argument.arg)]
        if isinstance(part, Value):
            given[str(argument.arg)] = _checked(kind, str(argument.arg), ast.literal_eval(argument.value))
        else:
            given[str(argument.arg)] = _read_node(argument.value, part)
    for field, value in (more or {}).items():
        given[field] = _checked(kind, field, value)
    return kind(line=call.lineno, **given)


def _keywords(call: ast.Call) -> dict[str, Any]:
    return {str(one.arg): ast.literal_eval(one.value) for one in call.keywords}


def _checked(kind: type[Node], field: str, value: Any) -> Any:
    """Return a value after the checks of a form."""
    feature = next(one for one in features(kind) if one.field == field)
    if not isinstance(feature.of, Value):
        raise TypeError(field)
    if isinstance(value, list):
        return tuple(feature.of.parse(str(one)) for one in value)
    return feature.of.parse(str(value))


def parts_at(brain: Brain) -> Iterator[tuple[str, int]]:
    """Yield the path of each population and projection with the line on which it begins."""
    for field in ("population", "projection"):
        for place, one in enumerate(getattr(brain, field)):
            yield f"{field}/{place}", one.line
