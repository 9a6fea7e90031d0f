"""Dictionaries of a script that are changed after its cells and synapses were made of them.

A dictionary that is passed by ``**``, or to PyNN, is copied, so nothing in the network knows it; the text of
the script tells that a change of it comes too late.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Collection, Iterator
from typing import Final

_CHANGES: Final = frozenset({"update", "setdefault", "pop", "clear", "popitem"})
_NOT_IN_ORDER: Final = (
    ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef, ast.For, ast.While, ast.If, ast.Match,
    ast.Try, ast.ListComp, ast.DictComp, ast.SetComp, ast.GeneratorExp,
)  # fmt: skip
"""Code that runs later than its line, several times or not at all."""


def late_changes(script: bytes, simulators: Collection[str] = ()) -> Iterator[str]:
    """Yield a sentence for each change of a dictionary that a script has already used and uses no more.

    Only dictionaries that the script makes itself are looked at, and only those that it uses in no other way
    than to pass them by ``**`` or to PyNN, in the order of its lines.

    Args:
        script: its text; one that is not Python yields nothing.
        simulators: the packages of simulators besides PyNN and this one.
    """
    try:
        body = ast.parse(script).body
    except (SyntaxError, ValueError):
        return
    known = set(_imported(body, {"pyNN", "nrp_core", *simulators}))
    if not known:
        return
    uses: dict[str, list[_Use]] = defaultdict(list)
    for statement in body:
        _collect(statement, known, uses)
    for name, found in uses.items():
        kinds = [kind for kind, _ in found]
        if kinds[:1] != ["made"] or kinds.count("made") > 1 or "other" in kinds or "passed" not in kinds:
            continue
        after = len(kinds) - kinds[::-1].index("passed")
        for _, node in found[after:]:
            yield (
                f"line {node.lineno}: '{ast.unparse(node)}' has no effect: '{name}' was already copied "
                f"in line {found[after - 1][1].lineno}"
            )


_Use = tuple[str, ast.expr | ast.stmt]
"""How a name is used: made, passed, changed or other; and where."""


def _imported(body: list[ast.stmt], packages: set[str]) -> Iterator[str]:
    for one in body:
        match one:
            case ast.Import(names):
                found = ((alias.name, alias.asname or alias.name.partition(".")[0]) for alias in names)
                yield from (own for name, own in found if name.partition(".")[0] in packages)
            case ast.ImportFrom(str() as module, names) if module.partition(".")[0] in packages:
                yield from (alias.asname or alias.name for alias in names)


def _collect(node: ast.AST, simulators: set[str], uses: dict[str, list[_Use]]) -> None:
    """Add each use of a name below a node, in the order of execution."""
    match node:
        case ast.Assign([ast.Name(name)], (ast.Dict() | ast.Call(ast.Name("dict"))) as value):
            _collect(value, simulators, uses)
            uses[name].append(("made", node))
        case (
            ast.Assign([ast.Subscript(ast.Name(name))], value)
            | ast.AugAssign(ast.Subscript(ast.Name(name)), _, value)
            | ast.AugAssign(ast.Name(name), ast.BitOr(), value)
        ):
            _collect(value, simulators, uses)
            uses[name].append(("changed", node))
        case ast.Expr(ast.Call(ast.Attribute(ast.Name(name), method), arguments, keywords) as call) if (
            method in _CHANGES
        ):
            for one in (*arguments, *keywords):
                _collect(one, simulators, uses)
            uses[name].append(("changed", call))
        case ast.Call():
            _collect_call(node, simulators, uses)
        case ast.Name(name):
            uses[name].append(("other", node))
        case _ if isinstance(node, _NOT_IN_ORDER):
            names = (one for one in ast.walk(node) if isinstance(one, ast.Name))
            for one in names:
                uses[one.id].append(("other", one))
        case _:
            for child in ast.iter_child_nodes(node):
                _collect(child, simulators, uses)


def _collect_call(call: ast.Call, simulators: set[str], uses: dict[str, list[_Use]]) -> None:
    """Add the names in a call; those that it copies are passed."""
    root = call.func
    while isinstance(root, ast.Attribute):
        root = root.value
    _collect(call.func, simulators, uses)
    copies = isinstance(root, ast.Name) and root.id in simulators
    mapped = [one.value for one in call.keywords if one.arg is None]
    for value in (*call.args, *(one.value for one in call.keywords)):
        if isinstance(value, ast.Name) and (copies or value in mapped):
            uses[value.id].append(("passed", call))
        else:
            _collect(value, simulators, uses)
