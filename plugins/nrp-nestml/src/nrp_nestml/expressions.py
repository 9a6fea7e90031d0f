"""Expressions of NESTML as texts in Python's notation, of magnitudes in NEST's units: mV, ms, pA, nS, pF."""

from __future__ import annotations

import re
from typing import Any, Final

from nrp_nestml.errors import NestmlError, at

_PREFIXES: Final = {
    "": 0, "m": -3, "u": -6, "n": -9, "p": -12, "k": 3, "M": 6, "G": 9, "f": -15, "c": -2, "d": -1,
}  # fmt: skip
_BASES: Final = {
    "V": -3, "A": -12, "s": -3, "S": -9, "F": -12, "Ohm": 9, "Hz": 3, "Bq": 3, "mol": -3, "K": 0,
}  # fmt: skip
"""The power of ten of NEST's unit of each kind, in SI units; a Hz is one in a ms there."""
_NAMES: Final = {
    "V": "mV", "A": "pA", "s": "ms", "S": "nS", "F": "pF", "Ohm": "Gohm", "Hz": "kHz", "Bq": "kHz",
}  # fmt: skip
_UNIT: Final = re.compile(rf"([{''.join(_PREFIXES)}]?)({'|'.join(_BASES)})")
_FUNCTIONS: Final = {
    "ln": "log", "log10": "log10", "exp": "exp", "expm1": "expm1", "abs": "abs", "min": "min", "max": "max",
    "sin": "sin", "cos": "cos", "tan": "tan", "sinh": "sinh", "cosh": "cosh", "tanh": "tanh", "ceil": "ceil",
    "floor": "floor", "clip": "clip",
}  # fmt: skip


def power_of(unit: str) -> int:
    """Return the power of ten by which a simple unit differs from NEST's of its kind; 0 for others."""
    match = _UNIT.fullmatch(unit)
    return _PREFIXES[match[1]] - _BASES[match[2]] if match else 0


def nest_unit(unit: str) -> str:
    """Return NEST's unit of the kind of a simple unit, or an empty text."""
    match = _UNIT.fullmatch(unit)
    return _NAMES.get(match[2], "") if match else ""


def plain(name: str) -> str:
    """Return a name of NESTML as one of Python."""
    return name.replace("$", "_aux").replace("'", "_prime")


class Writer:
    """Writes expressions.

    Args:
        names: the variables of the model; others are units.
        functions: its own functions, by name: the names of arguments, and the text of the result.
        calls: texts for calls such as ``convolve(g, spikes)``.
    """

    def __init__(
        self, names: set[str], functions: dict[str, tuple[list[str], str]], calls: dict[tuple[str, ...], str]
    ) -> None:
        self.names, self.functions, self.calls = names, functions, calls

    def text(self, node: Any) -> str:
        """Return an expression as a text.

        Raises:
            NestmlError: it has something that has no meaning in an equation.
        """
        if type(node).__name__ == "ASTSimpleExpression":
            return self._simple(node)
        if node.is_ternary_operator():
            condition, yes, no = (
                self.text(one) for one in (node.get_condition(), node.get_if_true(), node.get_if_not())
            )
            return f"(int({condition})*({yes}) + int(not ({condition}))*({no}))"
        if node.is_logical_not:
            return f"(not {self.text(node.get_expression())})"
        if node.is_unary_operator():
            return f"({str(node.get_unary_operator()).strip()}{self.text(node.get_expression())})"
        if node.get_expression() is not None:
            return f"({self.text(node.get_expression())})"
        operator = str(node.get_binary_operator()).strip()
        return f"({self.text(node.get_lhs())} {operator} {self.text(node.get_rhs())})"

    def _simple(self, node: Any) -> str:
        if node.is_function_call():
            return self._call(node.get_function_call())
        if node.is_inf_literal:
            return "inf"
        if node.get_boolean_literal() is not None:
            return str(int(node.get_boolean_literal()))
        number = node.get_numeric_literal()
        if number is not None:
            unit = node.unitType or node.get_variable()
            return f"{number!r}" if unit is None else f"({number!r}*{self._unit(str(unit), node)})"
        if node.is_string():
            raise NestmlError(f"{at(node)}: a string has no meaning in an equation")
        name = plain(node.get_variable().get_complete_name())
        if name in self.names or name in ("t", "e"):
            return name
        return self._unit(name, node)

    def _call(self, call: Any) -> str:
        name, arguments = call.get_name(), call.get_args() or []
        key = (name, *(str(argument).strip() for argument in arguments))
        if key in self.calls:
            return self.calls[key]
        texts = [self.text(argument) for argument in arguments]
        if name in self.functions:
            parameters, result = self.functions[name]
            return substituted(result, dict(zip(parameters, texts, strict=True)))
        if name not in _FUNCTIONS:
            raise NestmlError(f"{at(call)}: {name}(...) has no meaning in an equation")
        return f"{_FUNCTIONS[name]}({', '.join(texts)})"

    def _unit(self, text: str, node: Any) -> str:
        """Return the factor of a unit, such as 1000.0 for ``s``."""

        def factor(match: re.Match[str]) -> str:
            if not _UNIT.fullmatch(match[0]):
                raise NestmlError(f"{at(node)}: there is no variable or unit '{match[0]}'")
            return f"1e{power_of(match[0])}"

        return f"({re.sub(r'[A-Za-z_]+', factor, text.replace(' ', ''))})"


def substituted(text: str, values: dict[str, str]) -> str:
    """Return a text with names replaced by expressions, recursively."""
    if not values:
        return text
    pattern = re.compile(rf"\b({'|'.join(map(re.escape, values))})\b(?!\s*\()")
    return pattern.sub(lambda match: f"({values[match[1]]})", text)


def number_of(text: str) -> float | None:
    """Return the value of an expression of numbers alone; None for others."""
    import sympy

    value = sympy.nsimplify(sympy.sympify(text), rational=True)
    return float(value) if value.is_number else None
