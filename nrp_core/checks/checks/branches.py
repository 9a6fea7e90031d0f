"""Code that never runs, and conditions and values that are always the same."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import chain, pairwise
from typing import Final

from nrp_core.checks.declared import found_in
from nrp_core.checks.function_body import assigned
from nrp_core.checks.quoting import excerpt
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.scopes import SCOPES, own_nodes
from nrp_core.checks.static_experiment import StaticExperiment
from nrp_core.checks.used import local_names
from nrp_core.findings import Code, Finding, Level

Found = Iterator[tuple[ast.AST, str]]

_LEAVING: Final = {ast.Return: "returns", ast.Raise: "raises", ast.Break: "leaves", ast.Continue: "goes on"}
_SPACED: Final = 2
"""Columns from the end of a target to a sign that is written as ` =+`."""


@checks_experiment(Code.NRP320)
def code_can_act(static: StaticExperiment) -> Iterator[Finding]:
    """Look for branches and statements that are never reached, and for constants in place of comparisons."""
    for source in static.sources:
        for node in ast.walk(source.tree):
            for place, message in chain(
                _decided(node), _repeated(node), _unreached(node), _slips(node), _late(node), _alike(node)
            ):
                yield found_in(source, Code.NRP320, place, message, Level.WARNING)


def _decided(node: ast.AST) -> Found:
    """Yield the conditions that a constant makes always true: ``x == 1 or 2``."""
    if not isinstance(node, ast.If | ast.While | ast.IfExp):
        return
    for part in ast.walk(node.test):
        if not (isinstance(part, ast.BoolOp) and isinstance(part.op, ast.Or)):
            continue
        for before, value in pairwise(part.values):
            if isinstance(value, ast.Constant) and type(value.value) in (int, float, str) and value.value:
                meant = ""
                if isinstance(before, ast.Compare) and len(before.ops) == 1:
                    whole = ast.Compare(before.left, before.ops, [value])
                    meant = f"; did you mean '{ast.unparse(before)} or {ast.unparse(whole)}'?"
                yield part, f"'{excerpt(part)}' is always true, because of {value.value!r}{meant}"
                break


def _repeated(node: ast.AST) -> Found:
    """Yield the branches behind a condition that an earlier branch already has."""
    if not isinstance(node, ast.If) or any(isinstance(one, ast.Call) for one in ast.walk(node.test)):
        return
    branch: ast.If = node
    while len(branch.orelse) == 1 and isinstance(branch.orelse[0], ast.If):
        branch = branch.orelse[0]
        if ast.dump(branch.test) == ast.dump(node.test):
            text = excerpt(branch.test)
            yield branch.test, f"this branch is never taken: '{text}' is already tested in line {node.lineno}"
            return


def _unreached(node: ast.AST) -> Found:
    """Yield the first statement behind one that leaves its block; a ``yield`` there makes a generator."""
    for name in ("body", "orelse", "finalbody"):
        statements = getattr(node, name, None)
        if not isinstance(statements, list):
            continue
        for before, behind in pairwise(statements):
            verb = _LEAVING.get(type(before))
            if verb and not _is_meant_or_known(before, behind):
                yield behind, f"this is never reached: line {before.lineno} {verb}"
                break


def _is_meant_or_known(before: ast.stmt, behind: ast.stmt) -> bool:
    """Return whether a statement makes a generator, or another finding reports it."""
    ends_the_run = isinstance(before, ast.Raise) and "SystemExit" in ast.unparse(before)  # NRP302
    declares = isinstance(behind, ast.FunctionDef) and bool(behind.decorator_list)  # NRP210
    makes_generator = any(isinstance(one, ast.Yield | ast.YieldFrom) for one in ast.walk(behind))
    return ends_the_run or declares or makes_generator


def _alike(node: ast.AST) -> Found:
    """Yield conditions whose branches are the same."""
    if isinstance(node, ast.IfExp):
        one, other = ast.dump(node.body), ast.dump(node.orelse)
    elif isinstance(node, ast.If) and node.orelse and not any(isinstance(one, SCOPES) for one in node.body):
        one, other = ("".join(map(ast.dump, part)) for part in (node.body, node.orelse))
    else:
        return
    if one == other:
        yield node, f"both branches of '{excerpt(node.test)}' do the same"


def _late(node: ast.AST) -> Found:
    """Yield functions of a comprehension or loop that all use the last value of its variable."""
    if isinstance(node, ast.For):
        yield from _late_in_loop(node)
    if isinstance(node, ast.ListComp) and isinstance(node.elt, ast.Lambda):
        own = {one.arg for one in ast.walk(node.elt.args) if isinstance(one, ast.arg)}
        bound = {
            one.id for part in node.generators for one in ast.walk(part.target) if isinstance(one, ast.Name)
        }
        for one in ast.walk(node.elt.body):
            if isinstance(one, ast.Name) and one.id in bound - own:
                yield (
                    node.elt,
                    f"all these functions use the last '{one.id}'; write lambda ..., {one.id}={one.id}: ...",
                )
                return


def _late_in_loop(loop: ast.For) -> Found:
    """Yield transfer functions of a loop that use its variable, or what it assigns, when they are called."""
    changing = {one.id for one in ast.walk(loop.target) if isinstance(one, ast.Name)} | assigned(loop.body)
    for function in loop.body:
        if isinstance(function, ast.FunctionDef) and function.decorator_list:
            own = local_names(function)
            for one in own_nodes(function.body):
                if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load) and one.id in changing - own:
                    yield (
                        one,
                        f"'{one.id}' has its last value in all functions of this loop: they look it up when "
                        "they run",
                    )
                    break


def _slips(node: ast.AST) -> Found:
    """Yield ``x =+ 1``, which adds nothing, and quotients of constants that are rounded to 0."""
    match node:
        case ast.Assign([target], value):
            first = value
            while isinstance(first, ast.BinOp):
                first = first.left
            if not (isinstance(first, ast.UnaryOp) and isinstance(first.op, ast.UAdd | ast.USub)):
                return
            plus = isinstance(first.op, ast.UAdd)
            gap = first.col_offset - (target.end_col_offset or 0)
            is_close = target.end_lineno == first.lineno and gap == _SPACED
            is_plain = isinstance(first.operand, ast.Name | ast.Attribute | ast.Call | ast.Constant)
            if is_close and (plus or (is_plain and first.operand.col_offset - first.col_offset > 1)):
                signs = "+" if plus else "-"
                verb = "adds to" if plus else "subtracts from"
                name = ast.unparse(target)
                yield node, f"'={signs}' sets '{name}' to {ast.unparse(value)}; '{signs}=' {verb} it"
        case ast.BinOp(ast.Constant(int() as left), ast.FloorDiv(), ast.Constant(int() as right)):
            if right and left and left // right == 0:
                yield node, f"'{left} // {right}' is 0: '//' drops the fraction, and '/' keeps it"
        case ast.BinOp(ast.Constant(float() as left), ast.FloorDiv(), _) if 0 < left < 1:
            text = excerpt(node)
            yield (
                node,
                f"'{text}' is 0 for a divisor above {left:g}: '//' drops the fraction, and '/' keeps it",
            )
