"""Python transfer functions as transfer functions of the model."""

from __future__ import annotations

import ast
from dataclasses import replace
from typing import Any

from nrp_bibi.model.channels import (
    AnyDevice,
    DeviceChannel,
    DeviceGroupChannel,
    DeviceType,
    Local,
    PackagedDevice,
    Target,
    TopicChannel,
)
from nrp_bibi.model.expressions import FlowExpression
from nrp_bibi.model.functions import CALLS, BIBITransferFunction, Neuron2Monitor, Neuron2Robot, Robot2Neuron
from nrp_bibi.model.metamodel import Value
from nrp_bibi.model.selectors import NeuronGroupSelector
from nrp_bibi.model.synapses import (
    AllToAllConnector,
    FixedNumberPreConnector,
    NeuronConnector,
    TsodyksMarkramMechanism,
)
from nrp_bibi.model.values import NAME, NATURAL, RATE
from nrp_bibi.reverse.expressions import as_expression, dotted_name
from nrp_bibi.reverse.refusal import NotExpressibleError
from nrp_bibi.reverse.selectors import as_selector

_KINDS = {f"nrp.{kind.dsl_name}": kind for kind in DeviceType}
_DEVICES = ("nrp.MapSpikeSink", "nrp.MapSpikeSource")
_TOPICS = ("nrp.MapRobotSubscriber", "nrp.MapRobotPublisher")
_FUNCTIONS: dict[str, type[Neuron2Robot | Robot2Neuron]] = {
    "nrp.Neuron2Robot": Neuron2Robot, "nrp.Robot2Neuron": Robot2Neuron,
}  # fmt: skip


def as_function(function: ast.FunctionDef) -> BIBITransferFunction:
    """Return a transfer function as building blocks; the caller checks that they mean the same.

    Raises:
        NotExpressibleError: building blocks cannot express part of it.
    """
    if not function.decorator_list:
        raise NotExpressibleError(function.name)
    *mappings, last = [_Decorator(decorator) for decorator in function.decorator_list]
    if last.name == "nrp.NeuronMonitor":
        neurons, kind = last.take(2)
        shown = _device(last, function.name, neurons, kind)
        if not isinstance(shown, DeviceChannel):
            raise NotExpressibleError.of(neurons)
        return Neuron2Monitor(name=function.name, device=shown)
    if last.name not in _FUNCTIONS:
        raise NotExpressibleError.of(last.node)
    body = _Body(function, [_channel(mapping) for mapping in mappings])
    values = body.channels_with_bodies()
    if last.arguments:
        topic, type_ = _topic(last.arguments[0])
        values["return_value"] = TopicChannel(topic=topic, type=type_, body=body.returned)
    values |= _timing(last.literals())
    return _FUNCTIONS[last.name](name=function.name, local=tuple(body.locals), **values)


class _Decorator:
    """A decorator with its name and arguments."""

    def __init__(self, node: ast.expr) -> None:
        if not isinstance(node, ast.Call):
            raise NotExpressibleError.of(node)
        self.node = node
        self.name = dotted_name(node.func)
        self.arguments = node.args

    def take(self, count: int) -> list[ast.expr]:
        """Return the arguments; their number is checked."""
        if len(self.arguments) != count:
            raise NotExpressibleError.of(self.node)
        return self.arguments

    def literals(self) -> dict[str, Any]:
        """Return the keyword arguments, which must be literals."""
        try:
            return {one.arg or "": ast.literal_eval(one.value) for one in self.node.keywords}
        except ValueError:
            raise NotExpressibleError.of(self.node) from None


class _Body:
    """The statements of a function, sorted by kind."""

    def __init__(self, function: ast.FunctionDef, channels: list[AnyDevice | TopicChannel]) -> None:
        self._channels = {channel.name: channel for channel in channels}
        self._bodies: dict[str | None, FlowExpression] = {}
        self.locals: list[Local] = []
        self.returned: FlowExpression | None = None
        for statement in function.body:
            self._take(statement)

    def channels_with_bodies(self) -> dict[str, Any]:
        """Return the channels under their names in the model."""
        all_of = [replace(c, body=self._bodies.get(c.name)) for c in self._channels.values()]
        return {
            "device": tuple(c for c in all_of if isinstance(c, DeviceChannel)),
            "device_group": tuple(c for c in all_of if isinstance(c, DeviceGroupChannel)),
            "topic": tuple(c for c in all_of if isinstance(c, TopicChannel)),
        }

    def _take(self, statement: ast.stmt) -> None:
        match statement:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                self.locals.append(Local(name=name, body=self._expression(value)))
            case ast.Assign(targets=[ast.Attribute(value=ast.Name(id=name))], value=value):
                self._bodies[name] = self._expression(value)
            case ast.Expr(value=ast.Call(func=ast.Attribute(value=ast.Name(id=name)), args=[value])):
                self._bodies[name] = self._expression(value)
            case ast.Return(value=ast.expr() as value):
                self.returned = self._expression(value)
            case ast.Pass():
                pass
            case _:
                raise NotExpressibleError.of(statement)

    def _expression(self, value: ast.expr) -> FlowExpression:
        return as_expression(
            value, {name for name in self._channels if name} | {one.name for one in self.locals}
        )


def _channel(decorator: _Decorator) -> AnyDevice | TopicChannel:
    if decorator.name in _TOPICS:
        name, topic = decorator.take(2)
        address, type_ = _topic(topic)
        return TopicChannel(name=_text(name), topic=address, type=type_)
    if decorator.name in _DEVICES:
        name, neurons, kind = decorator.take(3)
        return _device(decorator, _text(name), neurons, kind)
    raise NotExpressibleError.of(decorator.node)


def _device(
    decorator: _Decorator, name: str, neurons: ast.expr, kind: ast.expr
) -> DeviceChannel | DeviceGroupChannel:
    selector, type_ = as_selector(neurons), _device_type(kind)
    settings = _settings(decorator.literals())
    if isinstance(selector, NeuronGroupSelector):
        return DeviceGroupChannel(name=name, type=type_, neurons=selector, **settings)
    return DeviceChannel(name=name, type=type_, neurons=selector, **settings)


def _device_type(kind: ast.expr) -> DeviceType | PackagedDevice:
    match kind:
        case ast.Call(func=ast.Attribute(value=ast.Name(id="nrp"), attr="device"), args=[name], keywords=[]):
            return PackagedDevice(_text(name))
    if dotted_name(kind) not in _KINDS:
        raise NotExpressibleError.of(kind)
    return _KINDS[dotted_name(kind)]


def _timing(given: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of the model that say when a function runs, for keyword arguments."""
    rate, triggers = given.get("throttling_rate"), given.get("triggers") or ()
    names = (triggers,) if isinstance(triggers, str) else triggers
    if not isinstance(names, (list, tuple)):
        raise NotExpressibleError(repr(triggers))
    return {
        "priority": _valid(NATURAL, given.get("priority", 0)),
        "throttling_rate": None if rate is None else _valid(RATE, rate),
        "trigger": tuple(_valid(NAME, one) for one in names),
        "calls": _choice(CALLS, given.get("calls", "once")),
    }


def _choice(kind: Value, text: Any) -> Any:
    """Return the member of an enumeration for its name in Python."""
    try:
        return kind.parse(text)
    except (ValueError, AttributeError):
        raise NotExpressibleError(repr(text)) from None


def _valid(kind: Value, value: Any) -> Any:
    """Return a value that a model can hold."""
    try:
        return kind.parse(kind.show(value))
    except ValueError:
        raise NotExpressibleError(repr(value)) from None


def _settings(given: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of the model for keyword arguments."""
    try:
        target = given.pop("receptor_type", None)
        dynamics = given.pop("synapse_type", None)
        return {
            "connector": _connector(given),
            "synapse_dynamics": None if dynamics is None else _dynamics(**dynamics),
            "target": None if target is None else Target(target.capitalize()),
        }
    except (TypeError, ValueError, AttributeError, KeyError) as error:
        raise NotExpressibleError(str(error)) from None


def _connector(given: dict[str, Any]) -> NeuronConnector | None:
    numbers = {"weights": given.pop("weight", None), "delays": given.pop("delay", None)}
    fixed = given.pop("connector", None)
    if given or not all(value is None or type(value) in (int, float) for value in numbers.values()):
        raise ValueError(given or numbers)
    if fixed is not None:
        return FixedNumberPreConnector(count=fixed["n"], **numbers)
    return AllToAllConnector(**numbers) if any(value is not None for value in numbers.values()) else None


def _dynamics(*, type: str, U: float, tau_rec: float, tau_facil: float) -> TsodyksMarkramMechanism:  # noqa: A002, N803
    if type != "TsodyksMarkram":
        raise ValueError(type)
    return TsodyksMarkramMechanism(u=U, tau_rec=tau_rec, tau_facil=tau_facil)


def _topic(node: ast.expr) -> tuple[str, str]:
    match node:
        case ast.Call(func=ast.Name(id="Topic"), args=[name, kind], keywords=[]):
            return _text(name), dotted_name(kind)
        case _:
            raise NotExpressibleError.of(node)


def _text(node: ast.expr) -> str:
    if not (isinstance(node, ast.Constant) and isinstance(node.value, str)):
        raise NotExpressibleError.of(node)
    return node.value
