"""The statements of a body: assignments, those at a spike with local values and choices."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Final

from nrp_nestml.errors import NestmlError, at
from nrp_nestml.expressions import Writer, plain, substituted

_SINCE_CROSSING: Final = re.compile(r"\((\w+)-\w+\)\*resolution\(\)/\(\1-(\w+)\)(?:/1(?:\.0)?ms)?")
"""The time since a threshold was crossed, interpolated between two steps."""


def small(body: Any) -> Iterator[Any]:
    """Yield the statements of a body that is not divided by conditions."""
    for statement in body.get_stmts():
        if statement.is_compound_stmt():
            raise NestmlError(f"{at(statement)}: a condition or loop here has no meaning in an equation")
        yield statement.small_stmt


def is_emitted(one: Any) -> bool:
    """Return whether a statement emits a spike."""
    return bool(one.is_function_call() and one.get_function_call().get_name() == "emit_spike")


def target(assignment: Any, writer: Writer) -> tuple[str, str]:
    """Return the variable of an assignment and its new value."""
    name = plain(assignment.get_variable().get_complete_name())
    value = writer.text(assignment.get_expression())
    for kind, sign in (("sum", "+"), ("minus", "-"), ("product", "*"), ("quotient", "/")):
        if getattr(assignment, f"is_compound_{kind}"):
            value = f"{name} {sign} ({value})"
    return name, value


class SpikeBody:
    """Reads the statements that run at a spike.

    Args:
        writer: of the model.
        previous: the variables that hold the value of another one before the step, where the spike is at a
            crossing: it is found within the step here, so no time has passed since it.

    Attributes:
        assignments: variables and their new values, in this order.
        emits: whether a spike is emitted.
        emitted: in a synapse, the weight of the emitted spike.
    """

    def __init__(self, writer: Writer, previous: dict[str, str]) -> None:
        self._writer, self._previous = writer, previous
        self._local: dict[str, str] = {}
        self.assignments: list[tuple[str, str]] = []
        self.emits, self.emitted = False, ""
        self._stale: set[str] = set()

    def read(self, body: Any) -> None:
        """Read a body.

        Raises:
            NestmlError: a statement has no meaning in a reset.
        """
        before = set(self._writer.names)
        for statement in body.get_stmts():
            if statement.is_compound_stmt():
                self._choice(statement.compound_stmt)
            elif is_emitted(statement.small_stmt):
                self._emit(statement.small_stmt)
            elif statement.small_stmt.is_declaration():
                self._declare(statement.small_stmt.get_declaration())
            else:
                self.assignments.append(self._assigned(statement.small_stmt))
        self._writer.names.intersection_update(before)

    def _emit(self, one: Any) -> None:
        given = one.get_function_call().get_args()
        self.emits = True
        if given:
            self.emitted = self._with_local(self._writer.text(given[0]), one)

    def _with_local(self, text: str, one: Any) -> str:
        """Return a text with local values written out, none of which has changed in the meantime."""
        for name in self._stale:
            if re.search(rf"\b{name}\b", text):
                raise NestmlError(f"{at(one)}: what the local value '{name}' depends on has changed")
        return substituted(text, self._local)

    def _assigned(self, one: Any) -> tuple[str, str]:
        if not one.is_assignment():
            raise NestmlError(f"{at(one)}: a spike only sets state variables")
        name, value = target(one.get_assignment(), self._writer)
        if name in self._local:
            raise NestmlError(f"{at(one)}: the local value '{name}' changes")
        found = name, self._with_local(value, one)
        self._stale |= {local for local, text in self._local.items() if re.search(rf"\b{name}\b", text)}
        return found

    def _declare(self, declaration: Any) -> None:
        expression = declaration.get_expression()
        if expression is None:
            raise NestmlError(f"{at(declaration)}: a value is missing")
        passed = _SINCE_CROSSING.fullmatch("".join(str(expression).split()))
        if passed is not None and self._previous.get(passed[2]) == passed[1]:
            text = "0.0"
        else:
            text = self._with_local(self._writer.text(expression), declaration)
        for variable in declaration.get_variables():
            name = plain(variable.get_complete_name())
            self._local[name] = text
            self._stale.discard(name)
        self._writer.names |= self._local.keys()

    def _choice(self, compound: Any) -> None:
        """Read ``if ...: ... else: ...`` as assignments that keep a value unless the condition holds."""
        chosen = compound.get_if_stmt()
        if chosen is None or chosen.has_elif_clauses():
            raise NestmlError(f"{at(compound)}: at a spike there are no loops and no elif")
        text = self._writer.text(chosen.get_if_clause().get_condition())
        condition = substituted(text, self._local)
        clauses = [(chosen.get_if_clause(), f"int({condition})", f"int(not ({condition}))")]
        if chosen.has_else_clause():
            clauses.append((chosen.get_else_clause(), *reversed(clauses[0][1:])))
        for clause, holds, fails in clauses:
            *_, last = [None, *small(clause.get_stmts_body())]
            for one in small(clause.get_stmts_body()):
                if one.is_declaration():
                    self._declare(one.get_declaration())
                    continue
                name, value = self._assigned(one)
                if re.search(rf"\b{name}\b", condition) and not (one is last and len(clauses) == 1):
                    raise NestmlError(f"{at(one)}: '{name}' is set where its own value is tested")
                self.assignments.append((name, f"({holds}*({value}) + {fails}*{name})"))
