"""The operations in the body of a transfer function, found without running it."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from nrp_core.checks.shapes import Shape, names_of
from nrp_core.errors import Instead, did_you_mean


@dataclass(frozen=True, slots=True)
class Read:
    """An attribute is read."""

    node: ast.Attribute
    owner: Shape
    name: str
    exists: bool


@dataclass(frozen=True, slots=True)
class Write:
    """An attribute is set; ``exists``: whether the object has it."""

    node: ast.Attribute
    owner: Shape
    name: str
    exists: bool
    value: Shape


@dataclass(frozen=True, slots=True)
class Call:
    """An object is called; ``is_whole``: whether all its arguments are known."""

    node: ast.Call
    callee: Shape
    given: tuple[Shape, ...]
    named: Mapping[str, Shape]
    is_whole: bool


@dataclass(frozen=True, slots=True)
class Divide:
    """A division or modulo operation."""

    node: ast.BinOp
    left: Shape
    right: Shape


@dataclass(frozen=True, slots=True)
class Add:
    """An addition, subtraction or comparison."""

    node: ast.expr
    left: Shape
    right: Shape


@dataclass(frozen=True, slots=True)
class Multiply:
    """A multiplication."""

    node: ast.BinOp
    left: Shape
    right: Shape


@dataclass(frozen=True, slots=True)
class Compute:
    """An operand of a computation or an order comparison."""

    node: ast.expr
    operand: Shape


@dataclass(frozen=True, slots=True)
class Index:
    """An item is read; ``index`` is None in a loop over all items."""

    node: ast.expr
    owner: Shape
    index: Shape | None


@dataclass(frozen=True, slots=True)
class Rename:
    """A parameter's name is assigned another value, so that its device or topic cannot be used any more."""

    node: ast.Name
    owner: Shape


@dataclass(frozen=True, slots=True)
class Return:
    """The function returns; ``value`` is None for a bare return."""

    node: ast.Return
    value: Shape | None


Event: TypeAlias = Read | Write | Call | Divide | Add | Multiply | Compute | Index | Rename | Return


def missing_name(event: Read) -> tuple[str, Instead | None]:
    """Return the message for a name that a module does not have, and what to replace it with."""
    hint = did_you_mean(event.name, names_of(event.owner))
    return f"'{ast.unparse(event.node.value)}' has no '{event.name}'{hint}", hint.instead
