"""Statements without effect: bare expressions, and values that are computed or filled but not used."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from nrp_core._support.lone_names import acts, lone_name
from nrp_core.checks.checks.names import unused_value
from nrp_core.checks.declared import Function, found_in
from nrp_core.checks.events import Call
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.scopes import SCOPES, own_nodes
from nrp_core.checks.shapes import Known
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.findings import Code, Finding, Level

_ARITHMETIC = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow, ast.MatMult)
"""Operators that only compute; `<<`, `>>` and `|` also connect things."""
_PURE = frozenset({"abs", "bool", "float", "int", "len", "max", "min", "round", "sorted", "str", "sum"})
"""Functions that only return a value."""
_PURE_OF = re.compile(
    r"math\.\w+|(np|numpy)\.(clip|abs|absolute|minimum|maximum|sqrt|exp|mean|sum|round|sign|roll|append|where)"
)
"""Functions of libraries that only return a value."""
_FRESH = (
    ast.BinOp, ast.UnaryOp, ast.Compare, ast.List, ast.Dict, ast.Set, ast.ListComp, ast.SetComp, ast.DictComp,
    ast.JoinedStr,
)  # fmt: skip
"""Expressions whose value is a new object, or one that cannot change."""
_FILLING = frozenset({"append", "extend", "insert", "add", "update", "setdefault"})
"""Methods of containers whose only effect is on the container."""
_LOOKING = frozenset({"locals", "vars", "exec", "eval"})
"""Functions that can read names which do not occur in the code."""


@checks_experiment(Code.NRP300)
def statements_have_an_effect(static: StaticExperiment) -> Iterator[Finding]:
    """Look for expression statements without effect."""
    for source in static.sources:
        tried = {
            id(one)
            for node in ast.walk(source.tree)
            if isinstance(node, ast.Try) and node.handlers
            for statement in node.body
            for one in ast.walk(statement)
        }
        for node in ast.walk(source.tree):
            message = _lost(node.value, id(node) in tried) if isinstance(node, ast.Expr) else _kept(node)
            if message:
                yield found_in(source, Code.NRP300, node, message, Level.WARNING)


def _lost(value: ast.expr, is_tried: bool) -> str:
    """Return why a bare expression has no effect; empty if it may have one.

    Args:
        value: the expression.
        is_tried: whether its exceptions are caught: then it may be a test.
    """
    text = excerpt(value)
    if isinstance(value, ast.Compare) and all(isinstance(sign, ast.Eq) for sign in value.ops):
        return f"'{text}' compares and assigns nothing: '=' assigns"
    if is_tried:
        return ""
    if isinstance(value, ast.Compare) or (
        isinstance(value, ast.BinOp) and isinstance(value.op, _ARITHMETIC) and not _is_text(value.left)
    ):
        return f"the value of '{text}' is not used"
    if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id in _PURE:
        return f"the value of '{text}' is not used"
    if isinstance(value, ast.Call) and _PURE_OF.fullmatch(ast.unparse(value.func)) and not value.keywords:
        return f"the value of '{text}' is not used"
    if acts(value):
        return ""
    if lone := lone_name(value):
        return lone
    if isinstance(value, (ast.BoolOp, ast.UnaryOp, ast.IfExp, ast.JoinedStr)) or _is_plain(value):
        return f"the value of '{text}' is not used"
    return ""


def _kept(node: ast.AST) -> str:
    """Return that an assignment gives an attribute the value that it has: ``eye.rate = eye.rate``."""
    match node:
        case ast.Assign([ast.Attribute() as target], ast.Attribute() as value):
            text = ast.unparse(target)
            return f"'{text}' is set to itself" if text == ast.unparse(value) and "(" not in text else ""
    return ""


def _is_text(value: ast.expr) -> bool:
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


def _is_plain(value: ast.expr) -> bool:
    """Return whether an expression is a number, or a tuple or list that is not empty."""
    if isinstance(value, ast.Constant):
        return type(value.value) in (int, float)
    return isinstance(value, (ast.Tuple, ast.List)) and bool(value.elts)


@checks_function(Code.NRP300)
def values_go_somewhere(function: CheckedFunction) -> Iterator[Finding]:
    """Look for messages that are not sent, and for values that only change themselves."""
    messages = {
        id(event.node)
        for event in function.events
        if isinstance(event, Call) and isinstance(event.callee, Known) and _is_message(event.callee.value)
    }
    for node in function.declared.own:
        if isinstance(node, ast.Expr) and id(node.value) in messages:
            message = f"the message '{excerpt(node.value)}' is made and not sent"
            yield function.declared.finding(Code.NRP300, node, message, Level.WARNING)
    for target, made in _filled(function.declared.node, messages):
        what = f"the message '{target.id}' is filled and not sent" if made else unused_value(target.id)
        yield function.declared.finding(Code.NRP300, target, what, Level.WARNING)
    for last, name in _filled_last(function.declared.node):
        what = f"'{name}' is filled and not returned here, so that this call publishes nothing"
        yield function.declared.finding(Code.NRP300, last, what, Level.WARNING)


def _filled_last(function: Function) -> Iterator[tuple[ast.stmt, str]]:
    """Yield where a function ends by filling a message that it returns elsewhere, and the message's name."""
    nodes = list(own_nodes(function.body))
    returned = {
        one.value.id for one in nodes if isinstance(one, ast.Return) and isinstance(one.value, ast.Name)
    }
    given = {
        one.id
        for call in nodes
        if isinstance(call, ast.Call)
        for one in call.args
        if isinstance(one, ast.Name)
    }
    blocks = [function.body]
    while blocks:
        *before, end = blocks.pop()
        if any(isinstance(one, ast.Return) for one in before):  # the end is never reached
            continue
        match end:
            case ast.If(_, body, orelse):
                blocks += [body, *([orelse] if orelse else [])]
            case ast.Assign([ast.Attribute() as target]) as last:
                name = ast.unparse(target).partition(".")[0]
                if name in returned - given - {one.arg for one in function.args.args}:
                    yield last, name


def _is_message(callee: object) -> bool:
    return isinstance(callee, type) and hasattr(callee, "__msgtype__")


def _filled(function: Function, messages: set[int]) -> Iterator[tuple[ast.Name, bool]]:
    """Yield the local names that are only used to change themselves, and whether each is a message."""
    nodes = list(own_nodes(function.body))
    if any(isinstance(one, ast.Name) and one.id in _LOOKING for one in nodes):
        return
    elsewhere = _used_elsewhere(function, nodes)
    own = _flows(nodes)
    stores = [one for one in nodes if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)]
    values = {id(target): value for target, value in _assignments(nodes)}
    grown = {id(one.target) for one in nodes if isinstance(one, ast.AugAssign)}
    for name in sorted({one.id for one in stores} - elsewhere):
        loads = [one for one in nodes if _is_load(one, name)]
        targets = sorted((one for one in stores if one.id == name), key=lambda one: one.lineno)
        made = [values.get(id(one)) for one in targets if id(one) not in grown]
        is_message = any(id(value) in messages for value in made)
        is_fresh = all(isinstance(one, (*_FRESH, ast.Constant)) or id(one) in messages for one in made)
        is_changed = loads or any(id(one) in grown for one in targets)  # pyflakes finds the others
        if made and is_fresh and is_changed and all(own.get(id(one)) == name for one in loads):
            yield targets[0], is_message


def _used_elsewhere(function: Function, nodes: list[ast.AST]) -> set[str]:
    """Return the parameters and the names that other scopes may use."""
    found = {one.arg for one in ast.walk(function.args) if isinstance(one, ast.arg)}
    for node in nodes:
        if isinstance(node, SCOPES):
            found |= {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
        if isinstance(node, (ast.Global, ast.Nonlocal)):
            found.update(node.names)
    return found


def _assignments(nodes: list[ast.AST]) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Yield the targets of assignments to names, each with its value."""
    for node in nodes:
        match node:
            case ast.Assign([ast.Name() as target], value):
                yield target, value
            case ast.AnnAssign(ast.Name() as target, _, ast.expr() as value):
                yield target, value


def _flows(nodes: list[ast.AST]) -> dict[int, str]:
    """Return the uses of names that only change the same name: ``x.a = 3``, ``x = x + 1``."""
    found: dict[int, str] = {}
    for node in nodes:
        match node:
            case ast.Attribute(owner, ctx=ast.Store()) | ast.Subscript(owner, ctx=ast.Store()):
                while isinstance(owner, ast.Attribute):  # an item may be a device
                    owner = owner.value
                found |= {id(owner): owner.id} if isinstance(owner, ast.Name) else {}
            case ast.Expr(ast.Call(ast.Attribute(ast.Name(name) as root, method))) if method in _FILLING:
                found[id(root)] = name
            case ast.Assign([ast.Name(name)], value) if not acts(value):
                found |= {id(one): name for one in ast.walk(value) if _is_load(one, name)}
    return found


def _is_load(node: ast.AST, name: str) -> bool:
    return isinstance(node, ast.Name) and node.id == name and not isinstance(node.ctx, ast.Store)
