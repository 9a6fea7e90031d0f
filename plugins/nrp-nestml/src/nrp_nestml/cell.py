"""A neuron of NESTML as the arguments of ``EquationCell``."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, Final

from nrp_nestml.declarations import Declarations
from nrp_nestml.dynamics import Dynamics
from nrp_nestml.errors import NestmlError, at
from nrp_nestml.expressions import number_of, plain, substituted
from nrp_nestml.reading import read
from nrp_nestml.statements import Behaviour, Reader
from nrp_nestml.synapse import synapse_of

_INPUT: Final = "i_offset"
_SPIKE: Final = "0.001"
"""The magnitude of a spike: a pulse of 1/s, in 1/ms."""


def model_of(path: Path) -> dict[str, Any]:
    """Return the arguments of ``EquationCell`` or ``EquationSynapse`` for the model in a file.

    Raises:
        NestmlError: the model uses something that these do not support.
    """
    model = read(path)
    is_synapse = any(
        "pre" in port.get_name() for block in model.get_input_blocks() for port in block.get_input_ports()
    )
    return synapse_of(model) if is_synapse else _Cell(model).arguments()


def cell_of(path: Path) -> dict[str, Any]:
    """Return the arguments of ``EquationCell`` for the neuron in a file.

    Every variable and parameter has its name and unit in the file. Injected currents go to the continuous
    port.

    Raises:
        NestmlError: it is not a neuron, or has something that cells in equations do not have.
    """
    return _Cell(read(path)).arguments()


class _Cell:
    def __init__(self, model: Any) -> None:
        self._name = model.get_name()
        self._given = Declarations(model)
        self._dynamics = Dynamics(model, self._given)
        self._does = self._behaviour(model)
        self._require_integrated()
        self._require_timer()
        gone = {self._does.timer, *self._does.previous, *self._does.shares}
        rates = {**self._dynamics.rates, **self._does.rates}
        if self._does.counter:  # the time that its steps take
            self._given.units[self._does.counter] = "ms"
            rates[self._does.counter] = "1.0"
        rates |= dict.fromkeys(self._given.initial.keys() - rates.keys(), "0.0")  # changes at spikes alone
        self._rates = {name: rate for name, rate in rates.items() if name not in gone}
        self._inlines = self._dynamics.inlines | self._does.shares
        for name in {one for one in self._does.previous.values() if f"{one}_falls" in self._does.threshold}:
            self._inlines[f"{name}_falls"] = self._rates[name]
        for name in filter(None, gone):
            if re.search(
                rf"\b{name}\b", " ".join((self._does.threshold, *self._does.reset, *self._rates.values()))
            ):
                raise NestmlError(f"'{name}' is used in a way that has no counterpart in a cell in equations")
        self._continuous = [plain(one.get_name()) for one in self._given.ports if not one.is_spike()]
        if len(self._continuous) > 1:
            raise NestmlError(f"it has {len(self._continuous)} continuous ports; there may be one")

    def _behaviour(self, model: Any) -> Behaviour:
        given = self._given
        spiking = {plain(port.get_name()) for port in given.ports if port.is_spike()}
        reader = Reader(given.writer, set(given.initial), {**given.internals, **given.parameters}, spiking)
        for block in model.get_update_blocks():
            reader.update(block.get_stmts_body())
        for block in model.get_on_receive_blocks():
            reader.received(plain(block.get_port_name()), block.get_stmts_body())
        for block in model.get_on_condition_blocks():
            reader.condition(block)
        if not reader.found.threshold:
            raise NestmlError("it has no onCondition block that emits a spike, so it is not a neuron")
        reader.found.effects.update(self._dynamics.pulses)
        return reader.found

    def _require_integrated(self) -> None:
        """Check that ``integrate_odes`` advances every variable that has an equation."""
        kernels = {name for kernel in self._dynamics.kernels.values() for name in kernel.rates}
        equations = self._dynamics.rates.keys() & self._given.initial.keys()
        for name in sorted(equations - kernels - {self._does.timer}):
            if re.sub(r"(_prime)+$", "", name) in self._does.runs or name in self._does.runs:
                continue
            when = " outside of the refractory period" if name in self._does.waits_with else ""
            raise NestmlError(f"no integrate_odes() integrates '{name}'{when}, which has an equation")

    def _require_timer(self) -> None:
        """Check that the refractory period begins at a spike, and passes at the rate of time."""
        timer = self._does.timer
        if not timer:
            return
        if timer not in self._does.waits_with | self._does.runs:
            raise NestmlError(f"no integrate_odes() integrates '{timer}', so its period would not end")
        if not self._does.is_counted and number_of(self._dynamics.rates.get(timer, "0")) != -1.0:
            raise NestmlError(f"'{timer}' counts a refractory period down, so its equation is {timer}' = -1")
        if self._given.number(timer) != 0.0:
            begins = f"'{timer}' is {self._given.number(timer):g} at the start"
            raise NestmlError(f"{begins}; a cell in equations begins outside of its refractory period: 0")

    def arguments(self) -> dict[str, Any]:
        """Return the arguments."""
        does = self._does
        refractory = f"({self._final(does.period)})*ms" if does.period else self._final(does.waits)
        result = {
            "equations": "\n".join([*self._definitions(), *self._derivatives()]),
            "threshold": self._final(does.threshold),
            "reset": "\n".join(map(self._assignment, does.reset)),
            "refractory": refractory or "0 ms",
            "receptors": self._receptors(), "name": self._name,
        }  # fmt: skip
        return {**result, "parameters": self._parameters(result), "initial": self._initial()}

    def _definitions(self) -> list[str]:
        return [f"{name} = {self._final(text)} : 1" for name, text in self._inlines.items()]

    def _derivatives(self) -> list[str]:
        found = []
        for name, rate in self._rates.items():
            held = " (unless refractory)" if name in self._does.held else ""
            found.append(f"d{name}/dt = {self._scaled(name, rate)}/ms : {self._given.unit(name)}{held}")
        return found

    def _receptors(self) -> dict[str, str]:
        """Return what spikes do, by receptor; several ports of no sign have their own names."""
        receptors: dict[str, str] = {}
        ports = [one for one in self._given.ports if one.is_spike()]
        for port in ports:
            both, name = port.is_excitatory() and port.is_inhibitory(), plain(port.get_name())
            receptor = "inhibitory" if port.is_inhibitory() and not both else "excitatory"
            receptor = name if both and len(ports) > 1 else receptor
            if receptor in receptors or port.has_size_parameter():
                raise NestmlError(
                    f"{at(port)}: it has more than one {receptor} port; cells in equations have an "
                    "excitatory and an inhibitory receptor, and one for each port of no sign"
                )
            effect = self._effect(name)
            if effect:
                receptors[receptor] = effect
        return receptors

    def _effect(self, port: str) -> str:
        """Return the effect of a spike at a port, or an empty text."""
        if port in self._dynamics.kernels:
            kernel = self._dynamics.kernels[port]
            if len(kernel.jumps) != 1:
                raise NestmlError(
                    f"kernel '{kernel.name}': a spike changes {len(kernel.jumps)} of its variables"
                )
            ((variable, jump),) = kernel.jumps.items()
            return f"{variable} += ({self._final(jump)})*weight"
        if port not in self._does.effects:
            return ""
        variable, added = self._does.effects[port]
        factor = re.sub(rf"\b{port}\b", _SPIKE, added)
        is_added = variable in self._does.held and port not in self._does.lost
        return f"{variable} += ({self._final(factor)})*weight" + (" (also refractory)" if is_added else "")

    def _parameters(self, texts: dict[str, Any]) -> dict[str, str]:
        """Return the defaults; a limit that is infinite and has no effect is omitted."""
        written = " ".join(map(str, texts.values()))
        found = {}
        for name in self._given.parameters:
            number = self._given.number(name)
            if math.isfinite(number) or re.search(rf"\b{name}\b", written):
                found[name] = _quantity(number, self._given.unit(name))
        return found | dict.fromkeys([_INPUT] if self._continuous else [], "0 pA")

    def _initial(self) -> dict[str, str]:
        kernels = {name for kernel in self._dynamics.kernels.values() for name in kernel.rates}
        return {
            name: _quantity(self._given.number(name), self._given.unit(name))
            for name in self._rates
            if name in self._given.initial and name not in kernels
        }

    def _assignment(self, text: str) -> str:
        name, _, value = text.partition(" = ")
        return f"{name} = {self._scaled(name, value)}"

    def _scaled(self, name: str, magnitude: str) -> str:
        """Return a magnitude as a quantity in the unit of a variable."""
        unit = self._given.unit(name)
        return f"({self._final(magnitude)})" + ("" if unit == "1" else f"*{unit}")

    def _final(self, text: str) -> str:
        """Return an expression of magnitudes as one of quantities, with internals written out."""
        for _ in self._given.internals:  # one may be in the text of another
            text = substituted(text, self._given.internals)
        units = {name: self._given.unit(name) for name in (*self._given.parameters, *self._given.initial)}
        values = {name: f"{name}/{unit}" for name, unit in units.items() if unit != "1"}
        return substituted(text, values | dict.fromkeys(self._continuous, f"{_INPUT}/pA"))


def _quantity(number: float, unit: str) -> str:
    if unit == "kHz":
        return f"{1e3 * number!r} Hz"
    return f"{number!r}" if unit == "1" else f"{number!r} {unit}"
