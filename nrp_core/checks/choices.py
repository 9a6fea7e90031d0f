"""Tests of one value against numbers that exclude each other, or that leave nothing out."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from math import inf
from typing import Final

from nrp_core.checks.quoting import excerpt

_BELOW: Final = (ast.Lt, ast.LtE)
_ABOVE: Final = (ast.Gt, ast.GtE)


def without_choice(tree: ast.AST) -> Iterator[tuple[ast.expr, str]]:
    """Yield ``x < 1 and x > 5``, ``x > 1 or x < 5`` and ``x != 1 or x != 2``, and what is wrong with each."""
    for node in ast.walk(tree):
        if isinstance(node, ast.BoolOp):
            answer = _answer(node)
        elif isinstance(node, ast.Compare) and len(node.ops) > 1:
            answer = _answer_of(_bounds(node), is_all=True)
        else:
            continue
        if answer:
            yield node, f"'{excerpt(node)}' is {answer}"


def _answer(node: ast.BoolOp) -> str:
    """Return that the parts of an ``and`` exclude each other, or that one of an ``or`` is always true."""
    is_all = isinstance(node.op, ast.And)
    parts = [one for one in node.values if isinstance(one, ast.Compare) and len(one.ops) == 1]
    unequal = defaultdict(set)
    for part in parts:
        value = number_of(part.comparators[0])
        if isinstance(part.ops[0], ast.NotEq) and value is not None and _is_pure(part.left):
            unequal[ast.dump(part.left)].add(value)
    if not is_all and any(len(values) > 1 for values in unequal.values()):
        return "always true: no value equals both numbers; 'and' was probably meant"
    return _answer_of([bound for part in parts for bound in _bounds(part)], is_all=is_all)


def _answer_of(bounds: list[tuple[str, bool, float]], *, is_all: bool) -> str:
    low: dict[str, float] = {}
    high: dict[str, float] = {}
    for key, is_low, number in bounds:
        if is_low:
            low[key] = max(low.get(key, -inf), number) if is_all else min(low.get(key, inf), number)
        else:
            high[key] = min(high.get(key, inf), number) if is_all else max(high.get(key, -inf), number)
    for key in low.keys() & high.keys():
        if is_all and low[key] > high[key]:
            return f"never true: nothing is above {low[key]:g} and below {high[key]:g}"
        if not is_all and low[key] < high[key]:
            return f"always true: every value is above {low[key]:g} or below {high[key]:g}"
    return ""


def _bounds(node: ast.Compare) -> list[tuple[str, bool, float]]:
    """Return what is bounded, whether from below, and by which number, for each sign of a comparison."""
    found = []
    operands = [node.left, *node.comparators]
    for left, sign, right in zip(operands, node.ops, operands[1:], strict=False):
        for value, limit, lower in ((left, right, _ABOVE), (right, left, _BELOW)):
            number = number_of(limit)
            if number is not None and _is_pure(value) and isinstance(sign, _BELOW + _ABOVE):
                found.append((ast.dump(value), isinstance(sign, lower), number))
    return found


def _is_pure(node: ast.expr) -> bool:
    """Return whether an expression has the same value twice, and is not written out."""
    return number_of(node) is None and not any(
        isinstance(one, ast.Call | ast.NamedExpr) for one in ast.walk(node)
    )


def number_of(node: ast.expr) -> float | None:
    """Return a number that is written out; None for anything else."""
    match node:
        case ast.Constant(bool()):
            return None
        case ast.Constant(int() | float() as number):
            return float(number)
        case ast.UnaryOp(ast.USub(), ast.Constant(int() | float() as number)):
            return -float(number)
    return None
