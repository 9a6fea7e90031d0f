"""State machines that are left out or whose transitions lead nowhere, found without running them.

SMACH compares them when a machine begins, and does not start one that fails (``check_consistency``).
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from nrp_core._support.dotted import last_name
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_legacy.code import Source
from nrp_legacy.constants import with_constants
from nrp_legacy.notes import unnoted

_BEGINNING: Final = 4096  # bytes to search for the first element
_MACHINES: Final = ("StateMachine", "Sequence", "Concurrence", "Iterator")


def is_scxml(path: Path) -> bool:
    """Return whether a file holds a state machine in SCXML, whatever its name ends in."""
    with path.open("rb") as file:
        return re.search(rb"<(\w+:)?scxml\b", file.read(_BEGINNING)) is not None


def scxml_message(path: Path) -> str:
    """Return the report of a state machine in SCXML. The platform never executed one."""
    return (
        f"state machine left out: {path.name} is in SCXML, which the Neurorobotics Platform did not execute "
        "either; only Python (SMACH) is run"
    )


def check_machine_file(path: Path) -> Iterator[Finding]:
    """Yield a finding for each transition that leads nowhere, and for each state that is added twice."""
    if is_scxml(path):
        yield Finding(Code.NRP273, scxml_message(path), Level.WARNING, path, subject=path.name)
        return
    try:
        tree = Source.of_file(path).tree(unnoted)
    except ExperimentError as error:
        message = f"state machine left out: {error.message}"
        yield Finding(Code.NRP273, message, Level.WARNING, error.path, error.line)
        return
    tree = with_constants(tree)
    yield from _repeated_states(tree, path)
    adds = [node for node in ast.walk(tree) if isinstance(node, ast.Call) and _adds(node)]
    labels = [_text(call.args[0]) if call.args else None for call in adds]
    outcomes = _outcomes(tree)
    if outcomes is None or None in labels:
        return  # some are computed
    known = {*outcomes, *(label for label in labels if label)}
    for call, label in zip(adds, labels, strict=True):
        for target in _targets(call):
            name = _text(target)
            if name is not None and name not in known:
                hint = did_you_mean(name, known)
                message = (
                    f"the state '{label}' goes to '{name}', which is neither a state nor an outcome{hint}"
                )
                yield Finding(Code.NRP273, message, Level.WARNING, path, target.lineno, subject=name)


def _repeated_states(tree: ast.Module, path: Path) -> Iterator[Finding]:
    """Yield the states that one block adds again: the later one replaces the first."""
    for block in (node for node in ast.walk(tree) if isinstance(node, ast.With)):
        first: dict[str, int] = {}
        for statement in block.body:
            call = statement.value if isinstance(statement, ast.Expr) else None
            label = _text(call.args[0]) if isinstance(call, ast.Call) and _adds(call) and call.args else None
            if label is not None and first.setdefault(label, statement.lineno) != statement.lineno:
                message = f"the state '{label}' already exists, at line {first[label]}; rename one"
                yield Finding(Code.NRP273, message, Level.WARNING, path, statement.lineno, subject=label)


def _adds(call: ast.Call) -> bool:
    match call.func:
        case ast.Attribute(ast.Name(owner) | ast.Attribute(attr=owner), "add"):
            return owner in _MACHINES
    return False


def _outcomes(tree: ast.Module) -> set[str] | None:
    """Return the outcomes of all machines of a file; None if some are computed."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and last_name(node.func) in _MACHINES:
            given = [*node.args[:1], *(one.value for one in node.keywords if "outcome" in str(one.arg))]
            for value in given:
                items = getattr(value, "elts", [value])
                texts = [_text(item) for item in items]
                if None in texts:
                    return None
                found |= {text for text in texts if text is not None}
    return found


def _targets(call: ast.Call) -> list[ast.expr]:
    given = [*call.args[2:3], *(one.value for one in call.keywords if one.arg == "transitions")]
    return [value for one in given if isinstance(one, ast.Dict) for value in one.values]


def _text(node: ast.expr) -> str | None:
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None
