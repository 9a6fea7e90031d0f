"""Messages of an experiment's own ``.proto`` files, which are compiled when they are loaded.

Files of proto3 with messages and enumerations of plain fields are read, as NRP-core 4 takes them: its
compiler writes a module ``<package>_pb2`` with the messages, and one with their datapacks.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TypeAlias

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import Message

from nrp_core.errors import ExperimentError

_Field: TypeAlias = descriptor_pb2.FieldDescriptorProto
_COMMENTS = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_PACKAGE = re.compile(r"\bpackage\s+(\w+)\s*;")
_BLOCK = re.compile(r"\b(message|enum)\s+(\w+)\s*\{([^{}]*)\}")
_MEMBER = re.compile(r"(?:(optional|repeated)\s+)?([\w.]+)\s+(\w+)\s*=\s*(\d+)\s*(?:\[[^\]]*\])?\s*;")
_VALUE = re.compile(r"(\w+)\s*=\s*(-?\d+)\s*;")
_HEAD = re.compile(r'\b(syntax\s*=\s*"proto3"|package\s+\w+|option\s+[^;]+|import\s+[^;]+)\s*;')
_SCALARS = {
    "double", "float", "int32", "int64", "uint32", "uint64", "sint32", "sint64", "fixed32", "fixed64",
    "sfixed32", "sfixed64", "bool", "string", "bytes",
}  # fmt: skip


def own_messages(folder: Path) -> dict[str, dict[str, type[Message]]]:
    """Return the classes of the messages in the ``.proto`` files of a folder, by package and name.

    Raises:
        ExperimentError: a file has something else than messages and enumerations of plain fields.
    """
    found: dict[str, dict[str, type[Message]]] = {}
    for path in sorted(folder.glob("*.proto")):
        try:
            package, classes = _compiled(path.name, path.read_text("utf-8"))
        except (ExperimentError, UnicodeDecodeError, TypeError) as error:
            raise ExperimentError(
                f"this is not a file of proto3 that is read here: {error}", path=path
            ) from None
        found.setdefault(package, {}).update(classes)
    return found


@cache
def _compiled(name: str, text: str) -> tuple[str, dict[str, type[Message]]]:
    """Return the package of a file and its messages; one text always gives the same classes."""
    plain = _COMMENTS.sub("", text)
    package = _PACKAGE.search(plain)
    if package is None:
        raise ExperimentError("it names no package")
    rest = _BLOCK.sub("", _HEAD.sub("", plain)).strip(" \t\r\n;")
    if rest:
        raise ExperimentError(f"'{rest.split(maxsplit=1)[0]}' is not understood")
    file = descriptor_pb2.FileDescriptorProto(name=name, package=package[1], syntax="proto3")
    blocks = list(_BLOCK.finditer(plain))
    enums = {block[2] for block in blocks if block[1] == "enum"}
    messages = [block for block in blocks if block[1] == "message"]
    for block in blocks:
        if block[1] == "enum":
            values = [{"name": key, "number": int(number)} for key, number in _VALUE.findall(block[3])]
            file.enum_type.add(name=block[2], value=values)
    for block in messages:
        names = {each[2] for each in messages}
        file.message_type.add(name=block[2], field=_fields(package[1], block[3], enums, names))
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    found = (pool.FindMessageTypeByName(f"{package[1]}.{block[2]}") for block in messages)
    return package[1], {one.name: message_factory.GetMessageClass(one) for one in found}


def _fields(package: str, text: str, enums: set[str], messages: set[str]) -> Iterator[_Field]:
    if rest := _MEMBER.sub("", text).strip():
        raise ExperimentError(f"'{rest.split(maxsplit=1)[0]}' is not understood")
    for label, kind, name, number in _MEMBER.findall(text):
        field = _Field(name=name, number=int(number))
        field.label = _Field.LABEL_REPEATED if label == "repeated" else _Field.LABEL_OPTIONAL
        if kind in _SCALARS:
            field.type = _Field.Type.Value(f"TYPE_{kind.upper()}")
        elif kind in enums | messages:
            field.type = _Field.TYPE_ENUM if kind in enums else _Field.TYPE_MESSAGE
            field.type_name = f".{package}.{kind}"
        else:
            raise ExperimentError(
                f"the type of '{name}' must be a scalar, or an enum or message of this file, not '{kind}'"
            )
        yield field
