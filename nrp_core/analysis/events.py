"""What the body of a transfer function does, as far as that can be seen without running it."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from nrp_core.analysis.shapes import Shape, names_of
from nrp_core.errors import did_you_mean


@dataclass(frozen=True, slots=True)
class Read:
    """An attribute is read."""

    node: ast.Attribute
    owner: Shape
    name: str
    exists: bool


@dataclass(frozen=True, slots=True)
class Write:
    """An attribute is set; ``exists`` says whether there is one."""

    node: ast.Attribute
    owner: Shape
    name: str
    exists: bool
    value: Shape


@dataclass(frozen=True, slots=True)
class Call:
    """Something is called; ``is_whole`` says whether all its arguments are seen."""

    node: ast.Call
    callee: Shape
    given: tuple[Shape, ...]
    named: Mapping[str, Shape]
    is_whole: bool


@dataclass(frozen=True, slots=True)
class Divide:
    """Something is divided, or its remainder taken."""

    node: ast.BinOp
    left: Shape
    right: Shape


@dataclass(frozen=True, slots=True)
class Add:
    """Something is added, subtracted or compared."""

    node: ast.expr
    left: Shape
    right: Shape


@dataclass(frozen=True, slots=True)
class Multiply:
    """Something is multiplied."""

    node: ast.BinOp
    left: Shape
    right: Shape


@dataclass(frozen=True, slots=True)
class Compute:
    """Something is computed with, or compared by size."""

    node: ast.expr
    operand: Shape


@dataclass(frozen=True, slots=True)
class Index:
    """An item is taken; of a loop, which takes all, ``index`` is None."""

    node: ast.expr
    owner: Shape
    index: Shape | None


@dataclass(frozen=True, slots=True)
class Rename:
    """What a parameter stood for is out of reach: its name is given another value."""

    node: ast.Name
    owner: Shape


@dataclass(frozen=True, slots=True)
class Return:
    """The function returns; ``value`` is None where it returns nothing."""

    node: ast.Return
    value: Shape | None


Event: TypeAlias = Read | Write | Call | Divide | Add | Multiply | Compute | Index | Rename | Return


def missing_name(event: Read) -> str:
    """Return what to say of a module that does not have a name."""
    hint = did_you_mean(event.name, names_of(event.owner))
    return f"'{ast.unparse(event.node.value)}' has no '{event.name}'{hint}"
