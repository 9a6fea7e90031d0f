"""Message classes for DDS, of any type: fields for its comparison, and bytes from our codec."""

from __future__ import annotations

from typing import Any

from nrp_core.world.messages.cdr import Codec, MessageField


def dds_topic(topic: str) -> str:
    """Return the DDS name of a topic of ROS 2."""
    return f"rt{topic if topic.startswith('/') else f'/{topic}'}"


def dds_name(name: str) -> str:
    """Return the DDS name of the type ``package/msg/Type``."""
    package, kind, short = name.split("/")
    return f"{package}::{kind}::dds_::{short}_"


class DdsTypes:
    """Creates the classes.

    Args:
        codec: the codec with the types.
    """

    def __init__(self, codec: Codec) -> None:
        self._codec = codec
        self._made: dict[str, type[Any]] = {}

    def type(self, name: str) -> type[Any]:
        """Return the class of a type of the codec, ``package/msg/Type``; its instances hold bytes."""
        if name not in self._made:
            from cyclonedds.idl import make_idl_struct

            fields = {field.name: self._annotation(field) for field in self._codec.fields(name)}
            short = name.rpartition("/")[2]
            struct = make_idl_struct(short, dds_name(name), fields, dataclassify=False)
            struct.__init__ = _hold
            struct.serialize = _bytes
            struct.deserialize = struct.deserialize_key = classmethod(_made_of)
            self._made[name] = struct
        return self._made[name]

    def _annotation(self, field: MessageField) -> Any:
        from cyclonedds.idl import types

        plain = {"bool": bool, "string": str, "wstring": str, "byte": types.uint8, "char": types.uint8}
        if "/" in field.type:
            kind: Any = self.type(field.type)
        else:
            kind = plain.get(field.type) or getattr(types, field.type)
        if field.length is not None:
            return types.array[kind, field.length]
        if field.many:
            return types.sequence[kind, field.most] if field.most else types.sequence[kind]
        return kind


def _hold(self: Any, data: bytes | memoryview = b"") -> None:
    self.data = data


def _bytes(self: Any, *_args: object, **_options: object) -> bytes:
    return bytes(self.data)


def _made_of(cls: type[Any], data: bytes, /, *_args: object, **_options: object) -> Any:
    return cls(data)
