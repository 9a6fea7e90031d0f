"""The completions of an editor of expressions."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

from nrp_bibi.generation.walk import channels
from nrp_bibi.model.channels import TopicChannel
from nrp_bibi.model.expressions import Call
from nrp_bibi.model.functions import Bibi, BIBITransferFunction

from nrp_cockpit.designer.surroundings import Surroundings
from nrp_cockpit.designer.tree import at, function_of
from nrp_core.dsl import tf_lib
from nrp_core.messages.base import type_of

_MATHS = ("min", "max", "abs", "math.sqrt", "math.sin", "math.cos", "math.exp", "math.atan2")
_RESULTS = {"nrp.tf_lib.detect_red": tf_lib.RedShares}


def words_for(model: Bibi, path: str, surroundings: Surroundings) -> Iterator[dict[str, str]]:
    """Yield the names that an expression inside a function can use."""
    function = at(model, function_of(path)) if function_of(path) else None
    if isinstance(function, BIBITransferFunction):
        yield from _variables(function)
    yield _word("t", "variable", "time, s")
    for name in tf_lib.__all__:
        if callable(getattr(tf_lib, name)) and name.islower():
            yield _word(f"nrp.tf_lib.{name}", "function", "library")
    for name in _MATHS:
        yield _word(name, "function", "")
    for kind in sorted({topic.type for topic in surroundings.topics.values() if topic.is_heard}):
        yield from _messages(kind)


def _variables(function: BIBITransferFunction) -> Iterator[dict[str, str]]:
    for channel in channels(function):
        if not isinstance(channel, TopicChannel):
            yield _word(f"{channel.name}.{channel.type.default_property}", "variable", channel.type.value)
        elif channel.body is None:
            yield _word(f"{channel.name}.value", "variable", channel.type)
            for field in _fields(channel.type):
                yield _word(f"{channel.name}.value.{field}", "property", channel.type)
    for local in function.local:
        yield _word(local.name, "variable", "local")
        if isinstance(local.body, Call):
            for field in _fields(local.body.type):
                yield _word(f"{local.name}.{field}", "property", local.body.type)


def _messages(kind: str) -> Iterator[dict[str, str]]:
    """Yield a message and the messages that it contains."""
    yield _word(kind, "class", "message")
    found = type_of(kind.replace(".", "/"))
    for field in dataclasses.fields(found) if found and dataclasses.is_dataclass(found) else ():
        inner = field.default_factory if field.default_factory is not dataclasses.MISSING else None
        name = getattr(inner, "__msgtype__", "")
        if name:
            yield _word(name.replace("/", "."), "class", f"{field.name} of {kind}")


def _fields(kind: str) -> list[str]:
    if kind in _RESULTS:
        return [name for name in dir(_RESULTS[kind]) if not name.startswith("_")]
    found = type_of(kind.replace(".", "/"))
    return [field.name for field in dataclasses.fields(found)] if dataclasses.is_dataclass(found) else []


def _word(label: str, kind: str, detail: str) -> dict[str, str]:
    return {"label": label, "type": kind, "detail": detail}
