"""A synapse of NESTML as the arguments of ``EquationSynapse``."""

from __future__ import annotations

import re
from keyword import iskeyword
from typing import Any, Final

from nrp_nestml.bodies import SpikeBody, small
from nrp_nestml.declarations import Declarations
from nrp_nestml.errors import NestmlError, at
from nrp_nestml.expressions import plain, substituted

_WEIGHT: Final = "w"
_PRE, _POST = "pre", "post"


def synapse_of(model: Any) -> dict[str, Any]:
    """Return the arguments of ``EquationSynapse`` for a synapse.

    Its weight is the number ``w`` of the file, as given in scripts. A keyword of Python, such as
    ``lambda``, gets a trailing underscore.

    Raises:
        NestmlError: it uses something that synapses in equations do not support.
    """
    return _Synapse(model).arguments()


class _Synapse:
    def __init__(self, model: Any) -> None:
        self._name = model.get_name()
        self._given = Declarations(model)
        ports = {plain(port.get_name()) for port in self._given.ports}
        if not ports <= {"pre_spikes", "post_spikes"}:
            raise NestmlError(f"its ports are {', '.join(sorted(ports))}; here pre_spikes and post_spikes")
        for block in model.get_update_blocks():
            for one in small(block.get_stmts_body()):
                if not (one.is_function_call() and one.get_function_call().get_name() == "integrate_odes"):
                    raise NestmlError(f"{at(one)}: between spikes only equations change a synapse")
        blocks = [one for block in model.get_equations_blocks() for one in block.get_ode_equations()]
        self._rates = {
            plain(one.get_lhs().get_name()): self._given.writer.text(one.get_rhs()) for one in blocks
        }
        self._booleans = {name for name, unit in self._given.units.items() if unit == "boolean"}
        self._changes: dict[str, list[str]] = {_PRE: [], _POST: []}
        emitted = ""
        for block in model.get_on_receive_blocks():
            port = plain(block.get_port_name())
            end = _POST if _POST in port else _PRE
            body = SpikeBody(self._given.writer, {})
            body.read(block.get_stmts_body())
            self._changes[end] += [f"{name} = {value}" for name, value in body.assignments]
            emitted = body.emitted or emitted
            if body.emitted and end == _POST:
                raise NestmlError(f"{at(block)}: only a spike of the source is sent on")
        if not emitted:
            raise NestmlError("it has no onReceive block that emits a spike, so it is not a synapse")
        if any(block.get_stmts_body().get_stmts() for block in model.get_on_condition_blocks()):
            raise NestmlError("an onCondition block has no meaning in a synapse in equations")
        self._share = self._share_of(emitted)

    def _share_of(self, emitted: str) -> str:
        """Return the share of the weight that is sent; empty if all of it is, and the weight changes."""
        changes = [line for end in self._changes.values() for line in end]
        if any(line.startswith(f"{_WEIGHT} = ") for line in changes):
            if emitted.strip("()") != _WEIGHT:
                raise NestmlError(f"it emits '{emitted}'; a synapse whose weight changes emits 'w'")
            return ""
        text = emitted.strip("()") if emitted.strip("()") == _WEIGHT else emitted
        share = "1.0" if text == _WEIGHT else re.sub(rf" \* {_WEIGHT}\)$", "", text.removeprefix("("))
        if re.search(rf"\b{_WEIGHT}\b", share):
            raise NestmlError(f"it emits '{emitted}', which is not a multiple of 'w'")
        return share

    def arguments(self) -> dict[str, Any]:
        """Return the arguments."""
        given = self._given
        states = [name for name in given.initial if name != _WEIGHT]
        lines = [self._line(name) for name in states]
        on_pre = [self._final(line) for line in self._changes[_PRE]]
        if self._share:
            on_pre.append(self._final(f"share = {self._share}"))
        numbers = {name: given.number(name) for name in (*given.parameters, *states) if name != _WEIGHT}
        return {
            "equations": "\n".join(lines) or "dunused/dt = 0/second : 1 (event-driven)",
            "on_pre": "\n".join(on_pre),
            "on_post": "\n".join(map(self._final, self._changes[_POST])),
            "parameters": {_safe(name): numbers[name] for name in given.parameters if name != _WEIGHT},
            "initial": {_safe(name): numbers[name] for name in states},
            "name": self._name,
        }

    def _line(self, name: str) -> str:
        rate = self._rates.get(name, "0.0")
        return f"d{_safe(name)}/dt = ({self._final(rate)})/ms : 1 (event-driven)"

    def _final(self, text: str) -> str:
        """Return a text of magnitudes with the names of the synapse in equations."""
        name, equals, value = text.rpartition(" = ") if " = " in text else ("", "", text)
        for one in self._booleans:  # a condition where it is tested, and a number where it is kept
            value = re.sub(rf"((?:int|not )\(+|not ){one}\b", rf"\1({one} > 0.5)", value)
        value = substituted(value, {_WEIGHT: "weight"})
        renamed = {one: _safe(one) for one in self._given.units if _safe(one) != one}
        value = re.sub(r"\b(" + "|".join(renamed or ["$^"]) + r")\b", lambda one: _safe(one[0]), value)
        return f"{'weight' if name == _WEIGHT else _safe(name)}{equals}{value}" if equals else value


def _safe(name: str) -> str:
    """Return a name that Python does not reserve."""
    return f"{name}_" if iskeyword(name) else name
