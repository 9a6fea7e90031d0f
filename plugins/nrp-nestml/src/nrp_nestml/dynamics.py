"""The equations of a model: rates of variables, kernels and pulses."""

from __future__ import annotations

import re
from typing import Any

from nrp_nestml.declarations import Declarations
from nrp_nestml.errors import NestmlError, at
from nrp_nestml.expressions import plain
from nrp_nestml.kernels import Kernel, is_pulse, kernels_of


class Dynamics:
    """The equations.

    Args:
        model: NESTML's syntax tree.
        given: its declarations.

    Attributes:
        kernels: the kernel of each port that has one.
        rates: the derivative of each variable, in its unit in a ms.
        inlines: expressions with a name.
        pulses: the variable and its increment per spike, for each port whose spikes are pulses in a rate.
    """

    def __init__(self, model: Any, given: Declarations) -> None:
        self._writer = given.writer
        blocks = model.get_equations_blocks()
        statements = [one for block in blocks for one in block.get_kernels()]
        kernels = [
            kernel
            for one in statements
            if not is_pulse(one)
            for kernel in kernels_of(one, given.writer, given.initial)
        ]
        self.kernels = self._convolved(str(model), kernels)
        self.rates = self._rates([one for block in blocks for one in block.get_ode_equations()])
        self.inlines = {
            plain(one.get_variable_name()): self._writer.text(one.get_expression())
            for block in blocks
            for one in block.get_inline_expressions()
        }
        self.pulses: dict[str, tuple[str, str]] = {}
        for one in filter(is_pulse, statements):
            self._take_pulses(plain(one.get_variables()[0].get_name()))
        for kernel in kernels:
            self.rates.update(kernel.rates)

    def _convolved(self, text: str, kernels: list[Kernel]) -> dict[str, Kernel]:
        """Return the kernel of each port; ``convolve`` means its variable, or a pulse, from now on."""
        ports: dict[str, set[str]] = {}
        for name, port in re.findall(r"convolve\(\s*([\w$]+)\s*,\s*(\w+)\s*\)", text):
            ports.setdefault(plain(name), set()).add(port)
            self._writer.calls["convolve", name, port] = f"{plain(name)}__{port}"
        found: dict[str, Kernel] = {}
        for kernel in kernels:
            mine = ports.get(kernel.name, set())
            if len(mine) != 1 or mine & found.keys():
                raise NestmlError(
                    f"kernel '{kernel.name}' and one port must be convolved with each other alone"
                )
            (port,) = mine
            found[port] = kernel
            for call, meaning in self._writer.calls.items():
                if meaning == f"{kernel.name}__{port}":
                    self._writer.calls[call] = kernel.name
        return found

    def _rates(self, equations: list[Any]) -> dict[str, str]:
        """Return the derivative of each variable; an equation of a higher order becomes several."""
        rates: dict[str, str] = {}
        for equation in equations:
            variable = equation.get_lhs()
            name, order = plain(variable.get_name()), variable.get_differential_order()
            if name in rates:
                raise NestmlError(f"{at(equation)}: '{name}' has two equations")
            for lower in range(order - 1):
                rates[name + "_prime" * lower] = name + "_prime" * (lower + 1)
            rates[name + "_prime" * (order - 1)] = self._writer.text(equation.get_rhs())
        return rates

    def _take_pulses(self, kernel: str) -> None:
        """Move the pulses of a kernel ``delta(t)`` from rates to what spikes add."""
        import sympy

        for variable, rate in self.rates.items():
            match = re.search(rf"\b{kernel}__(\w+)", rate)
            if match is None:
                continue
            symbols = {each: sympy.Symbol(each) for each in re.findall(r"[A-Za-z_]\w*", rate)}
            per_pulse = sympy.diff(sympy.sympify(rate, locals=symbols), symbols[match[0]])
            self.rates[variable] = rate.replace(match[0], "0.0")
            self.pulses[match[1]] = variable, f"({per_pulse})*{match[1]}*1000.0"
