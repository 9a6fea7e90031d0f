"""Kernels as equations: the response to a spike is the solution of a linear system that the spike starts."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from nrp_nestml.errors import NestmlError, at
from nrp_nestml.expressions import Writer, plain


@dataclass(frozen=True)
class Kernel:
    """A kernel.

    Args:
        name: its name.
        rates: the derivative of each of its variables.
        jumps: the value of each variable that is not 0 right after a spike.
    """

    name: str
    rates: dict[str, str]
    jumps: dict[str, str]


def is_pulse(kernel: Any) -> bool:
    """Return whether a kernel is ``delta(t)``: a spike changes a variable at once."""
    return [str(each).replace(" ", "") for each in kernel.get_expressions()] == ["delta(t)"]


def kernels_of(kernel: Any, writer: Writer, initial: dict[str, str]) -> list[Kernel]:
    """Return the kernels of one statement.

    Args:
        kernel: the statement.
        writer: of the model.
        initial: initial values of the state block, which are those after a spike.

    Raises:
        NestmlError: it is not an exponential, an alpha function or a system of equations.
    """
    variables, expressions = kernel.get_variables(), kernel.get_expressions()
    if all(variable.get_differential_order() == 0 for variable in variables):
        return [
            _function(plain(variable.get_name()), writer.text(expression), kernel)
            for variable, expression in zip(variables, expressions, strict=True)
        ]
    if any(variable.get_differential_order() != 1 for variable in variables):
        raise NestmlError(f"{at(kernel)}: a kernel has equations of the first order")
    names = [plain(variable.get_name()) for variable in variables]
    rates = {name: writer.text(each) for name, each in zip(names, expressions, strict=True)}
    jumps = {name: initial[name] for name in names if not _is_zero(initial[name])}
    return [Kernel(names[0], rates, jumps)]


def _is_zero(text: str) -> bool:
    return re.fullmatch(r"[(]*0(\.0*)?(\*\(1e-?\d+\))?[)]*", text) is not None


def _function(name: str, text: str, place: Any) -> Kernel:
    """Return the kernel of a function of time, by its derivatives at 0."""
    import sympy

    known = {each: sympy.Symbol(each, positive=True) for each in set(re.findall(r"[A-Za-z_]\w*", text))}
    known |= {"e": sympy.E, "exp": sympy.exp}
    f, t = sympy.sympify(text, locals=known), known.get("t", sympy.Symbol("t"))
    first = sympy.diff(f, t)
    ratio = sympy.simplify(first / f)
    if not ratio.has(t):
        return Kernel(name, {name: f"({ratio})*{name}"}, {name: str(f.subs(t, 0))})
    start, slope = sympy.simplify(f.subs(t, 0)), sympy.simplify(first.subs(t, 0))
    decay = sympy.symbols("decay")
    rest = sympy.simplify(sympy.diff(first, t) + 2 * decay * first + decay**2 * f)
    for found in sympy.solve(rest.subs(t, 0), decay):
        if start == 0 and sympy.simplify(rest.subs(decay, found)) == 0:
            other = f"{name}_aux"
            rates = {name: f"{other} - ({found})*{name}", other: f"-({found})*{other}"}
            return Kernel(name, rates, {other: str(slope)})
    raise NestmlError(f"{at(place)}: kernel '{name}' is neither an exponential nor an alpha function")
