"""Check that a model is valid and unambiguous."""

from __future__ import annotations

import keyword
from collections.abc import Iterable
from pathlib import Path

from nrp_bibi.generation.hiding import hidden
from nrp_bibi.generation.walk import bodies, channels, parts
from nrp_bibi.model.channels import AnyDevice, DeviceType
from nrp_bibi.model.expressions import ArgumentReference, Call, FlowExpression
from nrp_bibi.model.functions import (
    Bibi,
    BIBITransferFunction,
    Calls,
    ChannelTransferFunction,
    Neuron2Monitor,
    PythonTransferFunction,
)
from nrp_bibi.model.metamodel import Node
from nrp_bibi.model.selectors import (
    ChainSelector,
    MapSelector,
    NeuronSelector,
    NeuronSelectorTemplate,
    Population,
)
from nrp_core.dsl import TIME, message_packages
from nrp_core.errors import TransferFunctionError, did_you_mean


class Checker:
    """Checks a model and makes errors about its parts.

    Args:
        path: the model's file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def refuse(self, node: Node, message: str) -> TransferFunctionError:
        """Return an error that points to a part of the model."""
        return TransferFunctionError(message, path=self._path, line=node.line or None)

    def check(self, model: Bibi) -> None:
        """Check all transfer functions.

        Raises:
            TransferFunctionError: one is not valid, or is ambiguous.
        """
        taken: dict[str, Node] = {}
        for function in model.transfer_function:
            if isinstance(function, PythonTransferFunction):
                self._check_python(function)
            elif isinstance(function, BIBITransferFunction):
                self._check_name(function, function.name, taken, "transfer function")
                self._check_function(function)
        for node, name, user in hidden(model):
            message = f"the name '{name}' hides the Python name that line {user.line} uses; rename it"
            raise self.refuse(node, message)

    def _check_python(self, function: PythonTransferFunction) -> None:
        if (function.src is None) is not bool(function.code):
            raise self.refuse(function, "a PythonTransferFunction needs either a src or code, not both")

    def _check_function(self, function: BIBITransferFunction) -> None:
        taken: dict[str, Node] = {}
        for channel in channels(function):
            if not isinstance(function, Neuron2Monitor):
                self._check_name(channel, channel.name, taken, "channel")
            if isinstance(channel, AnyDevice):
                self._check_neurons(channel.neurons)
        for local in function.local:
            self._check_expression(local.body, taken)
            self._check_name(local, local.name, taken, "local")
        for body in bodies(function):
            self._check_expression(body, taken)
        if isinstance(function, ChannelTransferFunction):
            self._check_triggers(function)

    def _check_triggers(self, function: ChannelTransferFunction) -> None:
        devices: list[AnyDevice] = [*function.device, *function.device_group]
        recorders = [one for one in devices if one.type is DeviceType.SPIKE_RECORDER]
        read = [topic.name for topic in function.topic if topic.name and topic.body is None]
        read += [device.name for device in recorders if device.body is None]
        if function.calls is Calls.EACH and not function.trigger:
            raise self.refuse(function, f"'{function.name}' has calls='Each', but no trigger")
        for name in function.trigger:
            if name not in read:
                message = f"'{function.name}' cannot be triggered by '{name}'"
                reason = "it reads no topic or spike recorder of this name"
                raise self.refuse(function, f"{message}: {reason}{did_you_mean(name, read)}")

    def _check_name(self, node: Node, name: str | None, taken: dict[str, Node], what: str) -> None:
        if name is None:
            raise self.refuse(node, f"a {what} needs a name")
        if keyword.iskeyword(name) or name in (TIME, "nrp", "Topic", *message_packages()):
            raise self.refuse(node, f"a {what} cannot have the name '{name}': it is reserved")
        if name in taken:
            raise self.refuse(node, f"'{name}' is used twice, first on line {taken[name].line}; rename one")
        taken[name] = node

    def _check_expression(self, body: FlowExpression, known: dict[str, Node]) -> None:
        for part in parts(body):
            if isinstance(part, ArgumentReference) and part.name not in (TIME, *known):
                hint = did_you_mean(part.name, known)
                raise self.refuse(part, f"no channel and no earlier local has the name '{part.name}'{hint}")
            if isinstance(part, Call):
                self._check_call(part)

    def _check_call(self, call: Call) -> None:
        names = [argument.name for argument in call.argument]
        given = [name for name in names if name is not None]
        if given != names[len(names) - len(given) :]:
            raise self.refuse(call, f"'{call.type}': arguments without a name must come before named ones")
        for i, name in enumerate(given):
            if keyword.iskeyword(name) or name in given[:i]:
                reason = "given twice" if name in given[:i] else "a Python keyword"
                raise self.refuse(call, f"'{call.type}' cannot have the argument '{name}': it is {reason}")

    def _check_neurons(self, selector: Node) -> None:
        for part in parts(selector):
            if isinstance(part, MapSelector) and (part.count is None) is (part.source is None):
                raise self.refuse(part, "a MapSelector needs either a count or a source, not both")
            if isinstance(part, MapSelector) and _is_whole(part.source):
                raise self.refuse(part, "the source of a MapSelector needs a count or a population")
            if isinstance(part, ChainSelector) and not (part.neurons or part.connectors):
                raise self.refuse(part, "a ChainSelector needs neurons or connectors")
        for one in _selecting(selector):
            if one.population is None:
                raise self.refuse(one, f'this {type(one).__name__} needs population="..."')
            if not one.population.isidentifier() or keyword.iskeyword(one.population):
                raise self.refuse(
                    one, f"cannot use the population name '{one.population}': it is not a Python name"
                )


def _selecting(selector: Node) -> Iterable[NeuronSelector | NeuronSelectorTemplate]:
    """Return the selectors that name a population; the source of a map may only count."""
    sources = {id(part.source) for part in parts(selector) if isinstance(part, MapSelector)}
    found = (part for part in parts(selector) if isinstance(part, (NeuronSelector, NeuronSelectorTemplate)))
    return (part for part in found if part.population is not None or id(part) not in sources)


def _is_whole(source: Node | None) -> bool:
    return isinstance(source, Population) and source.count is None and source.population is None
