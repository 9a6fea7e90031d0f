"""Python selectors as selectors of the model."""

from __future__ import annotations

import ast
from typing import Any

from nrp_bibi.model.metamodel import Value
from nrp_bibi.model.selectors import (
    Box,
    ChainSelector,
    Index,
    IndexTemplate,
    List,
    ListTemplate,
    MapSelector,
    MultiNeuronSelector,
    Nearest,
    NeuronGroupSelector,
    NeuronSelector,
    NeuronSelectorTemplate,
    Population,
    Range,
    RangeTemplate,
    Sphere,
)
from nrp_bibi.model.values import NATURAL, POINT, POSITIVE, RATE, TEMPLATE
from nrp_bibi.reverse.expressions import dotted_name
from nrp_bibi.reverse.refusal import NotExpressibleError

_BRAIN = "nrp.brain."


class Normalized(ast.NodeTransformer):
    """Writes equal selections in one form.

    ``[slice(0, 3, 2)]`` becomes ``[0:3:2]`` and ``[[0, 2]]`` becomes ``[0, 2]``; mappings, parameters and
    settings of the function, which are matched by name, are sorted; its triggers become a list.
    """

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        self.generic_visit(node)
        *mappings, last = node.decorator_list
        node.decorator_list = [*sorted(mappings, key=ast.dump), _sorted(last)]
        node.args.args[1:] = sorted(node.args.args[1:], key=lambda one: one.arg)
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.Subscript:
        self.generic_visit(node)
        match node.slice:
            case ast.Call(func=ast.Name(id="slice"), args=[start, stop, *step], keywords=[]):
                node.slice = ast.Slice(start, stop, *step)
            case ast.List(elts=[_, _, *_] as elements):
                node.slice = ast.Tuple(elements, ast.Load())
        return node


def _sorted(decorator: ast.expr) -> ast.expr:
    """Return a decorator whose keywords are in order, with a list of triggers."""
    if isinstance(decorator, ast.Call):
        for keyword in decorator.keywords:
            if keyword.arg == "triggers" and isinstance(keyword.value, (ast.Constant, ast.Tuple)):
                one = keyword.value
                keyword.value = ast.List(one.elts if isinstance(one, ast.Tuple) else [one], ast.Load())
        decorator.keywords.sort(key=lambda keyword: keyword.arg or "")
    return decorator


def as_selector(node: ast.expr) -> NeuronSelector | NeuronGroupSelector:
    """Return the selector of the same neurons.

    Raises:
        NotExpressibleError: the model has no such selector.
    """
    match node:
        case ast.Call(func=ast.Attribute(value=owner, attr="within" | "nearest"), keywords=[]):
            return _located(node, _population(owner))
        case ast.Call():
            return _group(node)
        case _:
            return _neurons(node)


def _located(node: ast.Call, population: str) -> NeuronSelector:
    """Return the selector of neurons at a location."""
    match node:
        case ast.Call(func=ast.Attribute(attr="nearest"), args=[center, *count]) if len(count) < 2:
            number = _value(count[0], POSITIVE) if count else None
            return Nearest(population=population, center=_point(center), count=number)
        case ast.Call(args=[ast.Call(func=region, args=[first, second], keywords=[])]):
            if dotted_name(region) == "nrp.Box":
                return Box(population=population, low=_point(first), high=_point(second))
            if dotted_name(region) == "nrp.Sphere":
                return Sphere(population=population, center=_point(first), radius=_value(second, RATE))
    raise NotExpressibleError.of(node)


def _point(node: ast.expr) -> tuple[float, ...]:
    if not isinstance(node, ast.Tuple):
        raise NotExpressibleError.of(node)
    try:
        point: tuple[float, ...] = POINT.parse(" ".join(map(ast.unparse, node.elts)))
    except ValueError:
        raise NotExpressibleError.of(node) from None
    return point


def _group(node: ast.Call) -> NeuronGroupSelector:
    match dotted_name(node.func), node.args:
        case "nrp.map_neurons", [items, ast.Lambda(args=ast.arguments(args=[ast.arg(arg="i")]), body=body)]:
            count, source = _items(items)
            return MapSelector(count=count, source=source, pattern=_template(body))
        case "nrp.chain_neurons", parts:
            selectors = [as_selector(part) for part in parts]
            neurons = tuple(one for one in selectors if isinstance(one, NeuronSelector))
            groups = tuple(one for one in selectors if isinstance(one, NeuronGroupSelector))
            return ChainSelector(neurons=neurons, connectors=groups)
        case _:
            raise NotExpressibleError.of(node)


def _items(node: ast.expr) -> tuple[int | None, MultiNeuronSelector | None]:
    """Return the number of items, or their source."""
    match node:
        case ast.Call(func=ast.Name(id="range"), args=[count], keywords=[]):
            return _value(count, NATURAL), None
        case ast.Call(func=ast.Name(id="range"), args=[start, stop, *step], keywords=[]):
            return None, _range(start, stop, step[0] if step else None)
        case ast.List(elts=elements):
            return None, List(element=tuple(_value(element, NATURAL) for element in elements))
        case ast.Attribute(value=owner, attr="size"):
            return None, Population(population=_population(owner))
        case _:
            raise NotExpressibleError.of(node)


def _neurons(node: ast.expr) -> NeuronSelector:
    if not isinstance(node, ast.Subscript):
        return Population(population=_population(node))
    population = _population(node.value)
    match Normalized().visit(node).slice:
        case ast.Slice(lower=ast.expr() as start, upper=ast.expr() as stop, step=step):
            return _range(start, stop, step, population=population)
        case ast.Tuple(elts=elements) | ast.List(elts=elements):
            chosen = tuple(_value(one, NATURAL) for one in elements)
            return List(population=population, element=chosen)
        case index:
            return Index(population=population, index=_value(index, NATURAL))


def _range(
    start: ast.expr, stop: ast.expr, step: ast.expr | None = None, population: str | None = None
) -> Range:
    by = None if step is None else _value(step, NATURAL)
    return Range(population=population, from_=_value(start, NATURAL), to=_value(stop, NATURAL), step=by)


def _template(node: ast.expr) -> NeuronSelectorTemplate:
    if not isinstance(node, ast.Subscript):
        raise NotExpressibleError.of(node)
    population = _population(node.value)
    match node.slice:
        case ast.Slice(lower=ast.expr() as start, upper=ast.expr() as stop, step=step):
            by = None if step is None else _value(step, TEMPLATE)
            first, end = _value(start, TEMPLATE), _value(stop, TEMPLATE)
            return RangeTemplate(population=population, from_=first, to=end, step=by)
        case ast.Tuple(elts=elements) | ast.List(elts=elements):
            chosen = tuple(_value(one, TEMPLATE) for one in elements)
            return ListTemplate(population=population, element=chosen)
        case index:
            return IndexTemplate(population=population, index=_value(index, TEMPLATE))


def _population(node: ast.expr) -> str:
    name = dotted_name(node)
    population = name.removeprefix(_BRAIN)
    if name == population or "." in population:
        raise NotExpressibleError.of(node)
    return population


def _value(node: ast.AST, kind: Value) -> Any:
    try:
        return kind.parse(ast.unparse(node))
    except ValueError:
        raise NotExpressibleError.of(node) from None
