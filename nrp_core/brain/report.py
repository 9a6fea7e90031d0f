"""A backend's report on a network before it runs, for terminals, web pages and programs.

A backend gives numbers with their names and units; the program that shows them chooses the layout.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

from nrp_core.findings import Finding

Value: TypeAlias = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class Quantity:
    """The name, unit and format of a value.

    Args:
        name: identifier in JSON, with the unit: ``sdram_bytes``.
        title: heading in text: ``SDRAM``.
        form: Python format specification of a value; empty for ``str``.
        unit: unit written after the value.
        meaning: one sentence of explanation, if the title is not enough.
        is_detail: whether a short report omits it.
    """

    name: str
    title: str
    form: str = ""
    unit: str = ""
    meaning: str = ""
    is_detail: bool = False

    def shown(self, value: Value) -> str:
        """Return a value as text with its unit; a dash for None."""
        if value is None:
            return "-"
        if isinstance(value, bool):
            return "yes" if value else "no"
        text = value if isinstance(value, str) else format(value, self.form)
        return f"{text} {self.unit}" if self.unit else text


@dataclass(frozen=True, slots=True)
class Fact:
    """One value about the whole network."""

    quantity: Quantity
    value: Value

    def __str__(self) -> str:
        return self.quantity.shown(self.value)


@dataclass(frozen=True, slots=True)
class Table:
    """A table of values about parts of the network.

    Args:
        name: identifier in JSON.
        title: heading in text.
        columns: the quantity of each column.
        rows: the values, row by row.
        is_detail: whether a short report omits it.
    """

    name: str
    title: str
    columns: tuple[Quantity, ...]
    rows: tuple[tuple[Value, ...], ...]
    is_detail: bool = False

    def shown(self) -> list[list[str]]:
        """Return all values as text with their units."""
        return [[c.shown(value) for c, value in zip(self.columns, row, strict=True)] for row in self.rows]

    def is_number(self, column: int) -> bool:
        """Whether a column holds only numbers, which are aligned to the right."""
        return not any(isinstance(row[column], (str, bool)) for row in self.rows)


@dataclass(frozen=True, slots=True)
class Report:
    """One report on a network.

    Args:
        name: identifier in JSON.
        title: heading in text.
        facts: values about the whole network.
        tables: values about its parts.
        warnings: what would be lost or would not work.
        advice: possible improvements, one sentence each.
        notes: how accurate the numbers are.
    """

    name: str
    title: str
    facts: tuple[Fact, ...] = ()
    tables: tuple[Table, ...] = ()
    warnings: tuple[Finding, ...] = ()
    advice: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the report as JSON-compatible values: facts by name, table rows as objects."""
        return {
            "name": self.name,
            "title": self.title,
            "facts": {fact.quantity.name: fact.value for fact in self.facts},
            "tables": {table.name: _rows(table) for table in self.tables},
            "warnings": [warning.to_dict() for warning in self.warnings],
            "advice": list(self.advice),
            "notes": list(self.notes),
        }


def _rows(table: Table) -> list[dict[str, Value]]:
    names = [column.name for column in table.columns]
    return [dict(zip(names, row, strict=True)) for row in table.rows]
