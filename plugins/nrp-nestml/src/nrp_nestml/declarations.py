"""What a model declares: names, units, and the texts and numbers of values."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any, Final

from nrp_nestml.errors import NestmlError, at
from nrp_nestml.expressions import Writer, nest_unit, plain
from nrp_nestml.functions import read_functions

_FUNCTIONS: Final = (
    "exp",
    "expm1",
    "log",
    "log10",
    "sin",
    "cos",
    "tan",
    "sinh",
    "cosh",
    "tanh",
    "ceil",
    "floor",
)
_NUMBERS: Final[dict[str, Any]] = {
    **{name: getattr(math, name) for name in _FUNCTIONS},
    "abs": abs, "min": min, "max": max, "int": int, "inf": math.inf, "e": math.e,
    "steps": float, "__builtins__": {},
}  # fmt: skip
STEP: Final = "resolution()"
_NAME: Final = re.compile(r"[A-Za-z_]\w*")


class Declarations:
    """The declarations of a model.

    Args:
        model: NESTML's syntax tree.

    Attributes:
        units: the units of parameters, internals and variables, as written.
        ports: the input ports.
        writer: writes expressions with these names.
        parameters, internals, initial: texts of values.

    Raises:
        NestmlError: a vector, or a value that is missing.
    """

    def __init__(self, model: Any) -> None:
        blocks = {
            "parameters": model.get_parameters_blocks(), "internals": model.get_internals_blocks(),
            "state": model.get_state_blocks(),
        }  # fmt: skip
        self.units: dict[str, str] = {}
        for each in blocks.values():
            for declaration, name in _declared(each):
                if declaration.has_size_parameter():
                    raise NestmlError(f"{at(declaration)}: '{name}' is a vector, which equations do not have")
                self.units[name] = str(declaration.get_data_type()).strip()
        self.ports = [port for block in model.get_input_blocks() for port in block.get_input_ports()]
        self.writer = Writer(
            {*self.units, *_named(model), *(plain(one.get_name()) for one in self.ports)}, {}, {}
        )
        read_functions(list(model.get_functions()), self.writer)
        self.parameters, self.internals, self.initial = (
            {name: self._text(declaration) for declaration, name in _declared(each)}
            for each in blocks.values()
        )

    def unit(self, name: str) -> str:
        """Return the unit of a value in equations: NEST's of its kind, or 1."""
        return nest_unit(self.units.get(name, "")) or "1"

    def _text(self, declaration: Any) -> str:
        expression = declaration.get_expression()
        if expression is None:
            raise NestmlError(f"{at(declaration)}: a value is missing")
        if str(expression).strip() == STEP:
            return STEP
        call = expression.get_function_call() if hasattr(expression, "get_function_call") else None
        if call is not None and call.get_name() == "steps":
            return f"steps({self.writer.text(call.get_args()[0])})"
        return self.writer.text(expression)

    def number(self, name: str, path: tuple[str, ...] = ()) -> float:
        """Return the value of a parameter, or of a variable at the start.

        Raises:
            NestmlError: it depends on itself, or has no finite value.
        """
        if name in path:
            raise NestmlError(f"the value of '{name}' depends on itself")
        texts = {**self.parameters, **self.internals, **self.initial}
        inner = {
            each: self.number(each, (*path, name))
            for each in set(_NAME.findall(texts[name]))
            if each in texts
        }
        try:
            return float(eval(texts[name], _NUMBERS, inner))  # the writer let only arithmetic pass
        except (ArithmeticError, NameError, ValueError) as error:
            raise NestmlError(f"the value of '{name}', {texts[name]}, cannot be computed: {error}") from error


def _declared(blocks: Any) -> Iterator[tuple[Any, str]]:
    """Yield each declaration with each name that it declares."""
    for declaration in (one for block in blocks for one in block.get_declarations()):
        for variable in declaration.get_variables():
            yield declaration, plain(variable.get_complete_name())


def _named(model: Any) -> Iterator[str]:
    """Yield the names of inline expressions and kernels."""
    for block in model.get_equations_blocks():
        yield from (plain(one.get_variable_name()) for one in block.get_inline_expressions())
        for kernel in block.get_kernels():
            yield from (plain(variable.get_name()) for variable in kernel.get_variables())
