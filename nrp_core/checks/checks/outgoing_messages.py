"""Messages that do not fit their topic, that are not sent, or that their robot does not use."""

from __future__ import annotations

import ast
import dataclasses
import inspect
from collections.abc import Iterator, Mapping
from types import MethodType
from typing import Any, cast

from nrp_core.checks.checks.operations import no_value, not_called
from nrp_core.checks.code.declarations import Function, root_of
from nrp_core.checks.code.shapes import Call, Instance, Items, Known, Number, Return, Row, Shape, Write, hints
from nrp_core.checks.code.syntax import SCOPES, excerpt, own_nodes
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.parameters import PublishedTopic
from nrp_core.errors import TopicError
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.drives.drive import commanded_components
from nrp_core.world.messages.base import type_name
from nrp_core.world.messages.geometry_msgs import Twist, Vector3
from nrp_core.world.scene.model import Scene
from nrp_core.world.topics import TopicInfo, check_message

_PARTS = (ast.Attribute, ast.Subscript)


@checks_function(Code.NRP355)
def messages_are_sent(function: CheckedFunction) -> Iterator[Finding]:
    """Look for messages that are made or filled and not sent."""
    messages = {
        id(event.node)
        for event in function.events
        if isinstance(event, Call) and isinstance(event.callee, Known) and _is_message(event.callee.value)
    }
    for node in function.declared.own:
        if isinstance(node, ast.Expr) and id(node.value) in messages:
            message = f"the message '{excerpt(node.value)}' is made and not sent"
            yield function.declared.finding(Code.NRP355, node, message, Level.WARNING)
    for target in _filled(function.declared.node, messages):
        message = f"the message '{target.id}' is filled and not sent"
        yield function.declared.finding(Code.NRP355, target, message, Level.WARNING)
    for last, name in _filled_last(function.declared.node):
        message = f"'{name}' is filled and not returned here, so that this call publishes nothing"
        yield function.declared.finding(Code.NRP355, last, message, Level.WARNING)


def _filled_last(function: Function) -> Iterator[tuple[ast.stmt, str]]:
    """Yield where a function ends by filling a message that it returns elsewhere, and the message's name."""
    nodes = list(own_nodes(function.body))
    returned = {
        one.value.id for one in nodes if isinstance(one, ast.Return) and isinstance(one.value, ast.Name)
    }
    given = {
        one.id
        for call in nodes
        if isinstance(call, ast.Call)
        for one in call.args
        if isinstance(one, ast.Name)
    }
    blocks = [function.body]
    while blocks:
        *before, end = blocks.pop()
        if any(isinstance(one, ast.Return) for one in before):  # the end is never reached
            continue
        match end:
            case ast.If(_, body, orelse):
                blocks += [body, *([orelse] if orelse else [])]
            case ast.Assign([ast.Attribute() as target]) as last:
                name = ast.unparse(target).partition(".")[0]
                if name in returned - given - {one.arg for one in function.args.args}:
                    yield last, name


def _is_message(callee: object) -> bool:
    return isinstance(callee, type) and hasattr(callee, "__msgtype__")


def _filled(function: Function, messages: set[int]) -> Iterator[ast.Name]:
    """Yield the local names of messages of which only fields are set."""
    nodes = list(own_nodes(function.body))
    elsewhere = {one.arg for one in ast.walk(function.args) if isinstance(one, ast.arg)}
    for node in nodes:
        if isinstance(node, SCOPES):
            elsewhere |= {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
        if isinstance(node, (ast.Global, ast.Nonlocal)):
            elsewhere.update(node.names)
    set_in = {id(root_of(one)) for one in nodes if isinstance(one, _PARTS) and isinstance(one.ctx, ast.Store)}
    for node in sorted((one for one in nodes if isinstance(one, ast.Assign)), key=lambda one: one.lineno):
        match node:
            case ast.Assign([ast.Name(name) as target], value) if id(value) in messages:
                uses = [one for one in nodes if isinstance(one, ast.Name) and one.id == name]
                others = [one for one in uses if one is not target]
                if name not in elsewhere and others and all(id(one) in set_in for one in others):
                    yield target


_AGAIN = (ast.For, ast.AsyncFor, ast.While, ast.FunctionDef, ast.Lambda, ast.Global, ast.Nonlocal)
"""Code by which a later change may be sent all the same."""


@checks_function(Code.NRP355)
def messages_are_sent_when_they_are_whole(function: CheckedFunction) -> Iterator[Finding]:
    """Look for fields that are set after the message was sent, and of a message that is not used again."""
    body = function.declared.node.body
    nodes = list(own_nodes(body))
    if any(isinstance(node, _AGAIN) for statement in body for node in ast.walk(statement)):
        return
    sent = {id(event.node) for event in function.events if _is_sending(event)}
    for place, statement in enumerate(body):
        match statement:
            case ast.Expr(ast.Call(_, [ast.Name(name)], []) as call) if id(call) in sent:
                changed = [
                    found for later in body[place + 1 :] if (found := _set_in(later, name)) is not None
                ]
                used = sum(isinstance(one, ast.Name) and one.id == name for one in own_nodes(body[place:]))
                if changed and used == 1 + len(changed) and _is_own(name, nodes):
                    message = (
                        f"'{ast.unparse(changed[0])}' is set after line {call.lineno} has sent '{name}': the "
                        "change is not sent"
                    )
                    yield function.declared.finding(Code.NRP355, changed[0], message, Level.WARNING)


def _is_sending(event: object) -> bool:
    match event:
        case Call(_, Known(method), (Instance(),)):
            owner = getattr(method, "__self__", None)
            return isinstance(owner, PublishedTopic) and getattr(method, "__name__", "") == "send_message"
    return False


def _set_in(statement: ast.stmt, name: str) -> ast.Attribute | None:
    """Return the field of a message that a statement sets."""
    match statement:
        case ast.Assign([ast.Attribute() as target]) | ast.AugAssign(ast.Attribute() as target):
            root: ast.expr = target
            while isinstance(root, ast.Attribute):
                root = root.value
            return target if isinstance(root, ast.Name) and root.id == name else None
    return None


def _is_own(name: str, nodes: list[ast.AST]) -> bool:
    """Return whether a name is given once, by a call, and its object is known by no other name."""
    given = [one for one in nodes if isinstance(one, ast.Name) and one.id == name]
    made = [one for one in nodes if isinstance(one, ast.Assign) and isinstance(one.value, ast.Call)]
    targets = [id(target) for one in made for target in one.targets if len(one.targets) == 1]
    inner = {id(one.value) for one in nodes if isinstance(one, ast.Attribute)}
    stores = [one for one in given if isinstance(one.ctx, ast.Store)]
    whole = [one for one in given if isinstance(one.ctx, ast.Load) and id(one) not in inner]
    return len(stores) == 1 and id(stores[0]) in targets and len(whole) == 1


_HALVES = ("linear", "angular")
_AXES = ("x", "y", "z")


def drives_of(scene: Scene, experiment: Experiment) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Return the robot and the used components of each topic, or alias of one, that takes a Twist."""
    found = commanded_components(scene)
    return found | {alias: found[topic] for alias, topic in experiment.aliases.items() if topic in found}


@checks_experiment(Code.NRP299)
def events_command_what_drives_use(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events that publish a velocity that the drive ignores."""
    drives = {} if static.scene is None else drives_of(static.scene, static.experiment)
    for name, event in static.experiment.events.items():
        for said in event.publish:
            if said.topic in drives and isinstance(said.value, Mapping):
                for component in _components(said.value):
                    message = _ignored(component, *drives[said.topic])
                    if message:
                        place = static.experiment.place("events", name, "publish")
                        yield place.finding(Code.NRP299, message, Level.WARNING)


@checks_experiment(Code.NRP299)
def functions_command_what_drives_use(static: StaticExperiment) -> Iterator[Finding]:
    """Look for functions that send a velocity that the drive ignores."""
    drives = {} if static.scene is None else drives_of(static.scene, static.experiment)
    for function in static.functions:
        published = (static.topics.get(topic.name) for topic in function.function.published)
        commanded = {drives.get(info.name) for info in published if info is not None and info.type is Twist}
        if len(commanded) != 1 or None in commanded:
            continue  # the function may build a command for another drive
        (drive,) = commanded
        assert drive is not None
        for component, node in _set_components(function):
            message = _ignored(component, *drive)
            if message:
                yield function.declared.finding(Code.NRP299, node, message, Level.WARNING)


def _ignored(component: str, robot: str, used: tuple[str, ...]) -> str:
    """Return that a drive ignores a component; empty if it does not."""
    if component in used:
        return ""
    return f"'{component}' of the command has no effect: the drive of '{robot}' uses {', '.join(used)}"


def _components(value: Mapping[str, Any]) -> Iterator[str]:
    """Yield the components of a velocity in a file that are not 0."""
    for half in _HALVES:
        given = value.get(half)
        if isinstance(given, Mapping):
            yield from (f"{half}.{axis}" for axis in _AXES if given.get(axis))


def _set_components(function: CheckedFunction) -> Iterator[tuple[str, ast.AST]]:
    """Yield the components of a Twist that a body sets to another value than 0, each with its place."""
    vectors = {id(one.node): one.node for one in function.events if _makes(one, Vector3)}
    named = {
        target.id: value
        for statement in function.declared.own
        if isinstance(statement, ast.Assign) and id(value := statement.value) in vectors
        for target in statement.targets
        if isinstance(target, ast.Name)
    }
    for event in function.events:
        if isinstance(event, Call) and _makes(event, Twist):
            for half, given in _arguments(event.node, _HALVES).items():
                made = named.get(given.id) if isinstance(given, ast.Name) else given
                if isinstance(made, ast.Call) and id(made) in vectors:
                    for axis, value in _arguments(made, _AXES).items():
                        if not _is_zero(value):
                            yield f"{half}.{axis}", value
        match event:
            case Write(ast.Attribute(ast.Attribute(_, half)) as node, Instance(cls), axis, True, set_to):
                if cls is Vector3 and half in _HALVES and set_to != Known(0):
                    yield f"{half}.{axis}", node


def _makes(event: object, cls: type) -> bool:
    return isinstance(event, Call) and event.callee == Known(cls)


def _arguments(call: ast.Call, names: tuple[str, ...]) -> dict[str, ast.expr]:
    given = dict(zip(names, call.args, strict=False))
    return given | {one.arg: one.value for one in call.keywords if one.arg in names}


def _is_zero(value: ast.expr) -> bool:
    return isinstance(value, ast.Constant) and value.value == 0


_PLAIN: dict[Any, tuple[str, tuple[type, ...]]] = {
    float: ("a number", (int, float)),
    int: ("a whole number", (int,)),
    bool: ("true or false", (bool, int)),
    str: ("a text", (str,)),
}


@checks_function(Code.NRP240)
def constructor_arguments_have_the_field_types(function: CheckedFunction) -> Iterator[Finding]:
    """Compare the arguments of messages with their fields."""
    for event in function.events:
        match event:
            case Call(node, Known(type() as cls), given, named, True) if _is_message_class(cls):
                try:
                    bound = inspect.signature(cls).bind(*given, **named)
                except TypeError as error:
                    fields = ", ".join(field.name for field in dataclasses.fields(cls))
                    message = f"{type_name(cls)}({fields}): {error}"
                    yield function.declared.finding(Code.NRP240, node, message)
                    continue
                for name, shape in bound.arguments.items():
                    wrong = _misfit(function, shape, hints(cls).get(name))
                    if wrong:
                        message = f"{name} of {type_name(cls)} must be {wrong}"
                        yield function.declared.finding(Code.NRP240, node, message)


@checks_function(Code.NRP240)
def assigned_values_have_the_field_types(function: CheckedFunction) -> Iterator[Finding]:
    """Compare values assigned to fields of messages with the types of the fields."""
    for event in function.events:
        match event:
            case Write(node, Instance(cls), name, True, value) if _is_message_class(cls):
                wrong = _misfit(function, value, hints(cls).get(name))
                if wrong:
                    message = f"{name} of {type_name(cls)} must be {wrong}"
                    yield function.declared.finding(Code.NRP240, node, message)


@checks_function(Code.NRP240)
def sent_values_fit_the_topic(function: CheckedFunction) -> Iterator[Finding]:
    """Compare returned and sent values with the type of the topic."""
    for event in function.events:
        match event:
            case Return(node, value) if value is not None and function.returns_to is not None:
                info = function.returns_to
            case Call(node, Known(MethodType() as method), (value,), named, True) if (
                _sends(method) and not named
            ):
                info = cast(PublishedTopic, method.__self__).info
            case _:
                continue
        wrong = _refused(info, value)
        if wrong:
            yield function.declared.finding(Code.NRP240, node, wrong)


def _refused(info: TopicInfo, value: Shape) -> str:
    """Return why a topic would refuse a value; empty if it is not known to."""
    if not dataclasses.is_dataclass(info.type):
        return ""
    kind: Any = info.type
    fields = dataclasses.fields(kind)
    match value:
        case Instance(cls) if type_name(cls) != type_name(info.type):
            return f"{info.name} carries {type_name(info.type)}, not {type_name(cls)}"
        case Known(type() as cls):
            return (
                f"{info.name} carries {type_name(info.type)}, not its class; did you mean '{cls.__name__}()'?"
            )
        case Number() | Items() | Row() if isinstance(value, (Items, Row)) or len(fields) != 1:
            what = "a number" if isinstance(value, Number) else "a list"
            return f"{info.name} carries {type_name(info.type)}, not {what}"
        case Known(bool() | int() | float() | str() as plain):
            try:
                check_message(info, kind(plain) if len(fields) == 1 else plain)
            except TopicError as error:
                return error.message
    return ""


def _misfit(function: CheckedFunction, shape: Shape, hint: Any) -> str:
    """Return the type of a field if a value does not fit it, else an empty text."""
    wrong = no_value(function, shape) or not_called(shape)
    if wrong:
        return f"a value: {wrong}"
    is_message = dataclasses.is_dataclass(hint) and isinstance(hint, type)
    return _no_message(shape, hint) if is_message else _no_plain_value(shape, hint)


def _no_message(shape: Shape, hint: type) -> str:
    wanted = f"a {type_name(hint)}"
    match shape:
        case Instance(cls) if type_name(cls) != type_name(hint):
            return f"{wanted}, not a {type_name(cls)}"
        case Number():
            return f"{wanted}, not a number"
        case Items() | Row():
            return f"{wanted}, not a list"
        case Known(int() | float() | str() | None as value):
            return f"{wanted}, not {value!r:.40}"
    return ""


def _no_plain_value(shape: Shape, hint: Any) -> str:
    wanted, accepted = _PLAIN.get(hint, ("", (object,)))
    match shape:
        case Known(bool() | int() | float() | str() | None as plain) if not isinstance(plain, accepted):
            return f"{wanted}, not {plain!r:.40}"
        case Instance(cls) if wanted and cls is not hint:
            return f"{wanted}, not a {type_name(cls)}"
        case Items() | Row() if wanted:
            return f"{wanted}, not a list"
        case Number() if hint is str:
            return f"{wanted}, not a number"
    return ""


def _is_message_class(cls: type) -> bool:
    return dataclasses.is_dataclass(cls) and hasattr(cls, "__msgtype__")


def _sends(method: MethodType) -> bool:
    return isinstance(method.__self__, PublishedTopic) and method.__name__ == "send_message"
