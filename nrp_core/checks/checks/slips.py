"""Slips of Python that run without an error: loops, operators and arguments that do something else."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Final, TypeGuard

from nrp_core.checks.checks.names import replaced_parameter
from nrp_core.checks.checks.values import no_value
from nrp_core.checks.declared import found_in
from nrp_core.checks.events import Add
from nrp_core.checks.function_body import assigned
from nrp_core.checks.imported import full_names
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.scopes import own_nodes
from nrp_core.checks.shapes import Known, Number
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.findings import Code, Finding, Level

_GATHERS: Final = frozenset({"append", "extend", "add"})
_SEEDED: Final = frozenset({
    "numpy.random.default_rng", "numpy.random.seed", "numpy.random.RandomState", "random.seed",
    "random.Random",
})  # fmt: skip
_POWERS: Final = (2, 3)


@checks_experiment(Code.NRP320)
def code_does_what_it_looks_like(static: StaticExperiment) -> Iterator[Finding]:
    """Look for slips in the files of transfer functions and in the modules beside them."""
    for source in static.sources:
        for node in ast.walk(source.tree):
            message = next(filter(None, (look(node) for look in _LOOKS)), "")
            if message:
                yield found_in(source, Code.NRP320, node, message, Level.WARNING)


def _same_twice(node: ast.AST) -> str:
    """Return that an operation has one operand twice: ``min(a, a)``, ``a - a``, ``left.rate + left.rate``."""
    match node:
        case ast.BinOp(ast.Attribute() as one, ast.Add(), other):
            result = "twice the first one; is one of them another"
        case ast.Call(ast.Name("min" | "max"), [one, other], []):
            result = "the value itself"
        case ast.BinOp(one, ast.Sub(), other):
            result = "0"
        case ast.BinOp(one, ast.Div(), other):
            result = "1"
        case _:
            return ""
    if isinstance(one, ast.Constant) or any(isinstance(part, ast.Call) for part in ast.walk(one)):
        return ""
    text = ast.unparse(node)
    return f"'{text:.60}' has the same value twice: it is always {result}" if _same(one, other) else ""


def _many_limits(node: ast.AST) -> str:
    """Return that ``max(0, x, 1)`` does not clamp."""
    match node:
        case ast.Call(ast.Name("min" | "max" as name), args, []):
            written = [one.value for one in args if isinstance(one, ast.Constant)]
            numbers = [one for one in written if isinstance(one, int | float)]
            if 1 < len(numbers) < len(args):
                limit = max(numbers) if name == "max" else min(numbers)
                return (
                    f"of the numbers in '{excerpt(node)}' only {limit:g} matters; "
                    f"a value between two limits is min(max(x, low), high)"
                )
    return ""


def _power(node: ast.AST) -> str:
    """Return that ``x ^ 2`` is not a power."""
    match node:
        case ast.BinOp(_, ast.BitXor(), ast.Constant(int() as power)) if power in _POWERS:
            return f"'{excerpt(node)}' flips bits: a power is written '**'"
    return ""


def _ends_at_once(node: ast.AST) -> str:
    """Return that a loop that adds something up ends in its first round."""
    if not isinstance(node, ast.For | ast.While) or not node.body[:-1]:
        return ""
    last = node.body[-1]
    gathers = any(_is_gathering(one) for one in node.body[:-1])
    goes_on = any(isinstance(one, ast.Continue) for one in own_nodes(node.body))
    if isinstance(last, ast.Return | ast.Break) and gathers and not goes_on:
        verb = "returns" if isinstance(last, ast.Return) else "leaves"
        return f"this loop ends in its first round: line {last.lineno} {verb}, and is indented as its body"
    return ""


def _is_gathering(node: ast.stmt) -> bool:
    match node:
        case ast.AugAssign():
            return True
        case ast.Expr(ast.Call(ast.Attribute(_, method))):
            return method in _GATHERS
    return False


def _annotated(node: ast.AST) -> str:
    """Return that ``eye.rate: 2.0`` sets nothing."""
    match node:
        case ast.AnnAssign(ast.Attribute() | ast.Subscript() as target, annotation, None):
            where = ast.unparse(target)
            return f"'{where:.40}: {excerpt(annotation, 20)}' sets nothing: a value is assigned with '='"
    return ""


def _type_and_text(node: ast.AST) -> str:
    """Return that a type is never equal to a text: ``type(x) == "Image"``."""
    match node:
        case ast.Compare(ast.Call(ast.Name("type"), [_]), [ast.Eq() | ast.NotEq()], [ast.Constant(str())]):
            return f"'{excerpt(node)}' compares a type with a text: they are never equal"
    return ""


def _one_name(node: ast.AST) -> str:
    """Return that a loop is over one name: ``for joint in ("shoulder", "shoulder")``."""
    loops = getattr(node, "generators", [node] if isinstance(node, ast.For) else [])
    for loop in loops:
        items = getattr(loop.iter, "elts", [])
        names = [one.value for one in items if isinstance(one, ast.Constant) and isinstance(one.value, str)]
        if 1 < len(names) == len(items) and len(set(names)) == 1:
            return f"this loop goes {len(names)} times over '{names[0]}' alone; is one of them another?"
    return ""


_LOOKS: Final[tuple[Callable[[ast.AST], str], ...]] = (
    _same_twice, _many_limits, _power, _ends_at_once, _annotated, _type_and_text,
    _one_name,
)  # fmt: skip


@checks_function(Code.NRP320)
def numbers_of_generators_go_on(function: CheckedFunction) -> Iterator[Finding]:
    """Look for random numbers that begin again in every call, and generators that are read twice."""
    imported = full_names(function.declared.source.tree)
    nodes = function.declared.own
    for node in nodes:
        match node:
            case ast.Call(func, [ast.Constant(int())], []):
                first, dot, rest = ast.unparse(func).partition(".")
                if imported.get(first, first) + dot + rest in _SEEDED:
                    message = (
                        f"'{ast.unparse(node)}' starts again in every call, so the numbers are the same ones "
                        "each time; make the generator once, as the initial value of a variable"
                    )
                    yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)
            case ast.Assign([ast.Name(name)], ast.GeneratorExp()):
                reads = [one.lineno for one in _sure(function.declared.node.body) if _is_load(one, name)]
                stores = [one for one in nodes if isinstance(one, ast.Name) and one.id == name]
                is_stepped = any(ast.unparse(one).startswith(f"next({name}") for one in nodes)
                if len(reads) > 1 and not is_stepped and sum(not _is_load(one, name) for one in stores) == 1:
                    message = (
                        f"'{name}' gives its items once, and is empty when it is read again in line "
                        f"{reads[1]}: make a list"
                    )
                    yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)


@checks_function(Code.NRP320)
def truth_values_are_negated_by_not(function: CheckedFunction) -> Iterator[Finding]:
    """Look for ``~`` before the comparison of two numbers, which gives -1 or -2."""
    compared = {
        id(event.node)
        for event in function.events
        if isinstance(event, Add)
        and isinstance(event.left, Number | Known)
        and isinstance(event.right, Known)
    }
    for node in function.declared.own:
        match node:
            case ast.UnaryOp(ast.Invert(), ast.Compare() as test) if id(test) in compared:
                message = f"'{excerpt(node)}' is -1 or -2, and both count as true: write 'not'"
                yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)


@checks_function(Code.NRP320)
def conditions_are_of_values(function: CheckedFunction) -> Iterator[Finding]:
    """Look for conditions that are a parameter itself, which is true whatever its value is."""
    changed = assigned(function.declared.node.body)
    for node in function.declared.own:
        if not isinstance(node, ast.If | ast.While | ast.IfExp):
            continue
        tested = node.test.operand if isinstance(node.test, ast.UnaryOp) else node.test
        adapter = function.adapters.get(tested.id) if isinstance(tested, ast.Name) else None
        if adapter is None or ast.unparse(tested) in changed or _has_truth(adapter):
            continue
        wrong = no_value(function, Known(adapter))
        if wrong:
            message = f"this condition is the same for all values: {wrong}"
            yield function.declared.finding(Code.NRP320, node.test, message, Level.WARNING)


@checks_function(Code.NRP242)
def parameters_are_not_lost(function: CheckedFunction) -> Iterator[Finding]:
    """Look for values that replace a parameter after its last use, outside of loops."""
    body = function.declared.node.body
    nodes = list(own_nodes(body))
    own = {id(one) for one in nodes}
    inner = {
        one.id
        for statement in body
        for one in ast.walk(statement)
        if isinstance(one, ast.Name) and id(one) not in own
    }
    looped = {id(one) for loop in nodes if isinstance(loop, ast.For | ast.While) for one in ast.walk(loop)}
    reads: dict[str, int] = {}
    for one in nodes:
        if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load):
            reads[one.id] = max(reads.get(one.id, 0), one.lineno)
    for node in nodes:
        match node:
            case ast.Assign([ast.Name(name)]) if name in function.adapters.keys() - inner:
                if id(node) not in looped and 0 < reads.get(name, 0) < node.lineno:
                    yield function.declared.finding(
                        Code.NRP242, node, replaced_parameter(name), Level.WARNING
                    )


def _has_truth(adapter: object) -> bool:
    return any(hasattr(type(adapter), name) for name in ("__bool__", "__len__"))


def _sure(statements: list[ast.stmt]) -> Iterator[ast.AST]:
    """Yield the parts of the statements that every call executes, in their order."""
    for statement in statements:
        if isinstance(statement, ast.Assign | ast.AugAssign | ast.Expr | ast.Return):
            yield from ast.walk(statement)


def _is_load(node: ast.AST, name: str) -> TypeGuard[ast.Name]:
    return isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load)


def _same(one: ast.expr, other: ast.expr) -> bool:
    return ast.dump(one) == ast.dump(other)
