"""The update block, and what happens at spikes: recognised by the forms that NESTML's own models have."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass, field
from typing import Any, Final

from nrp_nestml.bodies import SpikeBody, is_emitted, small, target
from nrp_nestml.errors import NestmlError, at
from nrp_nestml.expressions import Writer, plain

_NEARLY: Final = "(1 - 1e-9)"
"""Of a period, so that rounding does not delay a cell that counts steps by one."""
_MILLISECOND: Final = re.compile(r"\*\s*(?:1(?:\.0*)?\s*)?ms\b")
"""A factor of one millisecond, as NESTML prints expressions."""


@dataclass
class Behaviour:
    """The behaviour of a model that its equations do not describe.

    Args:
        held: variables that stay in the refractory period.
        effects: the variable and the text that a spike of a port adds, by port.
        lost: ports whose spikes are lost in the refractory period.
        previous: variables that hold the value of another one before the step.
        rates: rates of variables that an update multiplies by ``exp(-step/tau)``.
        counter: the variable that counts the steps since the last spike.
        shares: expressions that replace variables that an update computes.
        timer: the variable that counts the refractory period down.
        is_counted: whether it counts steps, instead of being integrated.
        period: the text of its start value.
        waits: the condition that prevents spikes, if it is not a period.
        threshold: the condition for a spike.
        reset: assignments.
        runs: variables that are integrated outside of the refractory period.
        waits_with: variables that are integrated or counted in it.
    """

    held: set[str] = field(default_factory=set)
    effects: dict[str, tuple[str, str]] = field(default_factory=dict)
    lost: set[str] = field(default_factory=set)
    previous: dict[str, str] = field(default_factory=dict)
    rates: dict[str, str] = field(default_factory=dict)
    counter: str = ""
    shares: dict[str, str] = field(default_factory=dict)
    timer: str = ""
    is_counted: bool = False
    period: str = ""
    waits: str = ""
    threshold: str = ""
    reset: list[str] = field(default_factory=list)
    runs: set[str] = field(default_factory=set)
    waits_with: set[str] = field(default_factory=set)


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
        self._counter = ""
        self._shares: dict[str, str] = {}
        self.found = Behaviour()

    def update(self, body: Any) -> None:
        """Read the update block."""
        for statement in body.get_stmts():
            if statement.is_compound_stmt():
                self._branches(statement.compound_stmt)
            elif statement.small_stmt.is_function_call():
                always = self._integrated([statement.small_stmt])
                self.found.runs |= always
                self.found.waits_with |= always
            else:
                self._assigned(statement.small_stmt)

    def received(self, port: str, body: Any) -> None:
        """Read the effect of a spike, which may be none in the refractory period."""
        if port not in self._ports:
            raise NestmlError(f"{at(body)}: there is no spike port '{port}'; there are: {self._named()}")
        statements = body.get_stmts()
        if len(statements) == 1 and statements[0].is_compound_stmt() and self.found.timer:
            chosen = statements[0].compound_stmt.get_if_stmt()
            text = self._writer.text(chosen.get_if_clause().get_condition()) if chosen else ""
            if text == f"({self.found.timer} == 0)" and not (
                chosen.has_elif_clauses() or chosen.has_else_clause()
            ):
                body = chosen.get_if_clause().get_stmts_body()
                self.found.lost.add(port)
        for one in small(body):
            self._effect(one, port)

    def condition(self, block: Any) -> None:
        """Read the condition for a spike, and what follows."""
        if self.found.threshold:
            raise NestmlError(f"{at(block)}: a cell has one onCondition block")
        parts = self._crossing(conjuncts(self._writer.text(block.get_cond_expr())))
        timers = [_timer(part, "<=") for part in parts]
        # without a test of it here, the update alone keeps a cell from its threshold
        tested = next((name for name in timers if name in self._variables), self._counter)
        self.found.timer = self.found.timer or tested
        body = SpikeBody(self._writer, self.found.previous if self.found.waits else {})
        body.read(block.get_stmts_body())
        for name, value in body.assignments:
            if name == self.found.timer:
                self.found.period = self._steps(value) or value
            else:
                self.found.reset.append(f"{name} = {value}")
        if self.found.timer and not self.found.period:
            raise NestmlError(f"{at(block)}: a spike does not start the timer '{self.found.timer}'")
        if not body.emits:
            raise NestmlError(f"{at(block)}: an onCondition block emits a spike")
        self.found.threshold = " and ".join(
            self._peak(part)
            for part, timer in zip(parts, timers, strict=True)
            if not timer or timer != self.found.timer
        )
        if not self.found.threshold:
            raise NestmlError(f"{at(block)}: a spike needs a condition besides '{self.found.timer} <= 0 ms'")

    def _named(self) -> str:
        return ", ".join(sorted(self._ports)) or "none"

    def _crossing(self, parts: list[ast.expr]) -> list[ast.expr]:
        """Return the parts without ``V_m_old < V_th``: a cell waits while ``V_m >= V_th``, the other part."""
        texts = [ast.unparse(part) for part in parts]
        for k, text in enumerate(texts):
            before = re.fullmatch(r"(\w+) < (\w+)", text)
            if before is None or before[1] not in self.found.previous:
                continue
            crossed = f"{self.found.previous[before[1]]} >= {before[2]}"
            if crossed in texts:
                self.found.waits = f"({crossed})"
                return parts[:k] + parts[k + 1 :]
        return parts

    def _steps(self, value: str) -> str:
        """Return the time (ms) of an internal that is a number of steps, or an empty text."""
        match = re.fullmatch(r"steps\((.+)\)", self._internals.get(value.strip("()"), ""))
        return match[1] if match else ""

    def _peak(self, part: ast.expr) -> str:
        """Return a condition; that a variable was larger before the step becomes that it falls."""
        match = re.fullmatch(r"(\w+) > (\w+)", ast.unparse(part))
        if match is not None and self.found.previous.get(match[1]) == match[2]:
            return f"({match[2]}_falls < 0)"
        return f"({ast.unparse(part)})"

    def _branches(self, compound: Any) -> None:
        """Read ``if refr_t > 0: ... else: ...``."""
        chosen: Any = compound.get_if_stmt()
        if compound.is_if_stmt() and self._counted(chosen):
            return
        timer = ""
        if compound.is_if_stmt() and not chosen.has_elif_clauses():
            text = self._writer.text(chosen.get_if_clause().get_condition())
            match = re.fullmatch(
                r"(\w+) > 0(?:\.0)?(?: \* 1(?:\.0)?)?", ast.unparse(ast.parse(text, mode="eval"))
            )
            timer = match[1] if match else ""
        if timer not in self._variables:
            raise NestmlError(f"{at(compound)}: an update has no conditions but 'if refr_t > 0 ms'")
        self._counter = timer
        waiting = self._integrated(small(chosen.get_if_clause().get_stmts_body()))
        self.found.waits_with |= waiting
        if chosen.has_else_clause():
            running = self._integrated(small(chosen.get_else_clause().get_stmts_body()))
            self.found.runs |= running
            self.found.held |= running - waiting - {timer}

    def _counted(self, chosen: Any) -> bool:
        """Read ``if n >= period - 1: emit_spike() ... n = 0 else: n += 1``, where the period is in steps."""
        text = self._writer.text(chosen.get_if_clause().get_condition())
        match = re.fullmatch(r"\((\w+) >= \((\w+) - 1\)\)", text)
        period = self._steps(match[2]) if match else ""
        if match is None or not period or chosen.has_elif_clauses() or not chosen.has_else_clause():
            return False
        name = match[1]
        fires, counts = (
            list(small(clause.get_stmts_body()))
            for clause in (chosen.get_if_clause(), chosen.get_else_clause())
        )
        done, other = ([one for one in part if not is_emitted(one)] for part in (fires, counts))
        changes = [
            target(one.get_assignment(), self._writer) for one in (*done, *other) if one.is_assignment()
        ]
        if len(fires) != 2 or len(counts) != 1 or changes != [(name, "0"), (name, f"{name} + (1)")]:
            return False
        self.found.counter = name
        self.found.threshold = f"({name} >= ({period})*{_NEARLY})"
        self.found.reset.append(f"{name} = 0")
        self._shares[f"({name} / {match[2]})"] = f"({name})/({period})"
        return True

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
        name, value = target(one.get_assignment(), self._writer)
        if value in self._variables:
            self.found.previous[name] = value
            return name
        if name == self._counter and value == f"{name} - (1)":
            self.found.timer = name
            self.found.is_counted = True
            return name
        if value in self._shares:
            self.found.shares[name] = self._shares[value]
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
            self.found.rates[name] = f"-{name}/({step[2]})"
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
        name, value = target(one.get_assignment(), self._writer)
        ports = [port] if port else [each for each in self._ports if re.search(rf"\b{each}\b", value)]
        added = value.removeprefix(f"{name} + ")
        if _MILLISECOND.search(str(one.get_assignment().get_expression())):
            raise NestmlError(f"{at(one)}: a spike is a pulse in 1/s: it is multiplied by 1 s, not by 1 ms")
        if port and re.search(rf"\b{port}\b", value) is None:
            raise NestmlError(f"{at(one)}: what a spike of '{port}' adds does not depend on '{port}'")
        if len(ports) != 1 or added == value or ports[0] in self.found.effects:
            raise NestmlError(
                f"{at(one)}: a spike adds once to one state variable, in proportion to its weight"
            )
        self.found.effects[ports[0]] = name, added
