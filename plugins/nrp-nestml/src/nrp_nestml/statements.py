"""The update block, and what happens at spikes: recognised by the forms that NESTML's own models have."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from nrp_nestml.errors import NestmlError, at
from nrp_nestml.expressions import Writer, plain


@dataclass
class Behaviour:
    """What a model does besides its equations.

    Args:
        held: variables that stay in the refractory period.
        effects: the variable and the text that a spike of a port adds, by port.
        previous: variables that hold the value of another one before the step.
        decays: rates of variables that an update multiplies by ``exp(-step/tau)``.
        timer: the variable that counts the refractory period down.
        period: the text of its start value.
        threshold: the condition for a spike.
        reset: assignments.
    """

    held: set[str] = field(default_factory=set)
    effects: dict[str, tuple[str, str]] = field(default_factory=dict)
    previous: dict[str, str] = field(default_factory=dict)
    decays: dict[str, str] = field(default_factory=dict)
    timer: str = ""
    period: str = ""
    threshold: str = ""
    reset: list[str] = field(default_factory=list)


def conjuncts(text: str) -> list[ast.expr]:
    """Return the parts of a condition that must all hold."""

    def parts(node: ast.expr) -> list[ast.expr]:
        if isinstance(node, ast.BoolOp) and isinstance(node.op, ast.And):
            return [part for value in node.values for part in parts(value)]
        return [node]

    return parts(ast.parse(text, mode="eval").body)


def _timer(condition: ast.expr, comparison: str) -> str:
    """Return the variable that a condition compares with 0, or an empty text."""
    match = re.fullmatch(rf"(\w+) {comparison} 0(?:\.0)?(?: \* 1(?:\.0)?)?", ast.unparse(condition))
    return match[1] if match else ""


def small(body: Any) -> Iterator[Any]:
    """Yield the statements of a body that is not divided by conditions."""
    for statement in body.get_stmts():
        if statement.is_compound_stmt():
            raise NestmlError(f"{at(statement)}: a condition or loop here has no meaning in an equation")
        yield statement.small_stmt


class Reader:
    """Reads the statements of a model.

    Args:
        writer: of the model.
        variables: the variables that have equations.
        internals: texts of the internals.
        ports: names of the spike ports.
    """

    def __init__(
        self, writer: Writer, variables: set[str], internals: dict[str, str], ports: set[str]
    ) -> None:
        self._writer, self._variables = writer, variables
        self._internals, self._ports = internals, ports
        self.found = Behaviour()

    def update(self, body: Any) -> None:
        """Read the update block."""
        for statement in body.get_stmts():
            if statement.is_compound_stmt():
                self._branches(statement.compound_stmt)
            elif statement.small_stmt.is_function_call():
                self._integrated([statement.small_stmt])
            else:
                self._assigned(statement.small_stmt)

    def received(self, port: str, body: Any) -> None:
        """Read what a spike does."""
        for one in small(body):
            self._effect(one, port)

    def condition(self, block: Any) -> None:
        """Read the condition for a spike, and what follows."""
        if self.found.threshold:
            raise NestmlError(f"{at(block)}: a cell has one onCondition block")
        parts = conjuncts(self._writer.text(block.get_cond_expr()))
        timers = [_timer(part, "<=") for part in parts]
        self.found.timer = next((name for name in timers if name in self._variables), "")
        emits = False
        for one in small(block.get_stmts_body()):
            if one.is_function_call() and one.get_function_call().get_name() == "emit_spike":
                emits = True
            elif one.is_assignment():
                self._reset(one.get_assignment())
            else:
                raise NestmlError(f"{at(one)}: a spike only sets state variables")
        if self.found.timer and not self.found.period:
            raise NestmlError(f"{at(block)}: a spike does not start the timer '{self.found.timer}'")
        if not emits:
            raise NestmlError(f"{at(block)}: an onCondition block emits a spike")
        self.found.threshold = " and ".join(
            self._peak(part)
            for part, timer in zip(parts, timers, strict=True)
            if not timer or timer != self.found.timer
        )

    def _peak(self, part: ast.expr) -> str:
        """Return a condition; that a variable was larger before the step becomes that it falls."""
        match = re.fullmatch(r"(\w+) > (\w+)", ast.unparse(part))
        if match is not None and self.found.previous.get(match[1]) == match[2]:
            return f"({match[2]}_falls < 0)"
        return f"({ast.unparse(part)})"

    def _reset(self, assignment: Any) -> None:
        name, value = self._target(assignment)
        if name == self.found.timer:
            self.found.period = value
        else:
            self.found.reset.append(f"{name} = {value}")

    def _target(self, assignment: Any) -> tuple[str, str]:
        """Return the variable of an assignment and its new value."""
        name = plain(assignment.get_variable().get_complete_name())
        value = self._writer.text(assignment.get_expression())
        for kind, sign in (("sum", "+"), ("minus", "-"), ("product", "*"), ("quotient", "/")):
            if getattr(assignment, f"is_compound_{kind}"):
                value = f"{name} {sign} ({value})"
        return name, value

    def _branches(self, compound: Any) -> None:
        """Read ``if refr_t > 0: ... else: ...``."""
        chosen: Any = compound.get_if_stmt()
        timer = ""
        if compound.is_if_stmt() and not chosen.has_elif_clauses():
            text = self._writer.text(chosen.get_if_clause().get_condition())
            match = re.fullmatch(
                r"(\w+) > 0(?:\.0)?(?: \* 1(?:\.0)?)?", ast.unparse(ast.parse(text, mode="eval"))
            )
            timer = match[1] if match else ""
        if timer not in self._variables:
            raise NestmlError(f"{at(compound)}: an update has no conditions but 'if refr_t > 0 ms'")
        waiting = self._integrated(small(chosen.get_if_clause().get_stmts_body()))
        if chosen.has_else_clause():
            running = self._integrated(small(chosen.get_else_clause().get_stmts_body()))
            self.found.held |= running - waiting - {timer}

    def _integrated(self, statements: Any) -> set[str]:
        """Return the variables that are integrated or decay; all of them if the call names none."""
        names: set[str] = set()
        for one in statements:
            if not one.is_function_call():
                names.add(self._assigned(one))
                continue
            call = one.get_function_call()
            if call.get_name() != "integrate_odes":
                raise NestmlError(f"{at(one)}: {call.get_name()}(...) has no meaning in an equation")
            given = {plain(str(argument).strip()) for argument in call.get_args() or []}
            names |= given or set(self._variables)
        return names

    def _assigned(self, one: Any) -> str:
        """Read an assignment of the update block; return its variable."""
        if not one.is_assignment():
            raise NestmlError(f"{at(one)}: this statement has no meaning in an equation")
        name, value = self._target(one.get_assignment())
        if value in self._variables:
            self.found.previous[name] = value
            return name
        if any(re.search(rf"\b{port}\b", value) for port in self._ports):
            self._effect(one, "")
            return name
        decay = re.fullmatch(rf"\({name} \* (\w+)\)", value)
        step = (
            re.fullmatch(r"exp\(\(\(?-(\w+)\)? / (\w+)\)\)", self._internals.get(decay[1], ""))
            if decay
            else None
        )
        if step is not None and self._internals.get(step[1]) == "resolution()":
            self.found.decays[name] = f"-{name}/({step[2]})"
            return name
        if re.fullmatch(rf"max\((\w+), {name}\)", value) and self._never(value):
            return name
        raise NestmlError(f"{at(one)}: '{name} = {value}' in each step has no meaning in an equation")

    def _never(self, value: str) -> bool:
        """Return whether a limit is infinite, so that it has no effect."""
        limit = value.partition("(")[2].partition(",")[0]
        return "-inf" in self._internals.get(limit, "").replace(" ", "")

    def _effect(self, one: Any, port: str) -> None:
        if not one.is_assignment():
            raise NestmlError(f"{at(one)}: a spike only adds to state variables")
        name, value = self._target(one.get_assignment())
        ports = [port] if port else [each for each in self._ports if re.search(rf"\b{each}\b", value)]
        added = value.removeprefix(f"{name} + ")
        if len(ports) != 1 or added == value or ports[0] in self.found.effects:
            raise NestmlError(
                f"{at(one)}: a spike adds once to one state variable, in proportion to its weight"
            )
        self.found.effects[ports[0]] = name, added
