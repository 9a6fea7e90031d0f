"""What a backend has to say about a network before it runs, for people, pages and programs alike.

A backend fills in numbers and says what they are; how they look is the business of who shows them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

Value: TypeAlias = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a number or text is.

    Args:
        name: for programs, with its unit: ``sdram_bytes``.
        title: for people: ``SDRAM``.
        form: Python's format of a value; with nothing, as it is.
        unit: written behind a value.
        meaning: one sentence, where the title is not enough.
        is_detail: whether a short account leaves it out.
    """

    name: str
    title: str
    form: str = ""
    unit: str = ""
    meaning: str = ""
    is_detail: bool = False

    def shown(self, value: Value) -> str:
        """Return a value as people read it; what is not there is a dash."""
        if value is None:
            return "-"
        if isinstance(value, bool):
            return "yes" if value else "no"
        text = value if isinstance(value, str) else format(value, self.form)
        return f"{text} {self.unit}" if self.unit else text


@dataclass(frozen=True, slots=True)
class Fact:
    """One number or text about the whole."""

    quantity: Quantity
    value: Value

    def __str__(self) -> str:
        return self.quantity.shown(self.value)


@dataclass(frozen=True, slots=True)
class Table:
    """Many of the same kind.

    Args:
        name: for programs.
        title: for people.
        columns: what the values of a row are.
        rows: the values.
        is_detail: whether a short account leaves it out.
    """

    name: str
    title: str
    columns: tuple[Quantity, ...]
    rows: tuple[tuple[Value, ...], ...]
    is_detail: bool = False

    def shown(self) -> list[list[str]]:
        """Return all values as people read them."""
        return [[c.shown(value) for c, value in zip(self.columns, row, strict=True)] for row in self.rows]

    def is_number(self, column: int) -> bool:
        """Whether a column holds numbers, which stand to the right."""
        return not any(isinstance(row[column], (str, bool)) for row in self.rows)


@dataclass(frozen=True, slots=True)
class Report:
    """One account of a network.

    Args:
        name: for programs.
        title: for people.
        facts: about the whole.
        tables: about the parts.
        warnings: what would be lost or not work, one sentence each.
        advice: what else could be done better, likewise.
        notes: how far the numbers can be trusted.
    """

    name: str
    title: str
    facts: tuple[Fact, ...] = ()
    tables: tuple[Table, ...] = ()
    warnings: tuple[str, ...] = ()
    advice: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain values: facts by name, rows of tables as objects."""
        return {
            "name": self.name,
            "title": self.title,
            "facts": {fact.quantity.name: fact.value for fact in self.facts},
            "tables": {table.name: _rows(table) for table in self.tables},
            "warnings": list(self.warnings),
            "advice": list(self.advice),
            "notes": list(self.notes),
        }


def _rows(table: Table) -> list[dict[str, Value]]:
    names = [column.name for column in table.columns]
    return [dict(zip(names, row, strict=True)) for row in table.rows]
