"""Messages as bytes: the encoding of ROS 2 (CDR), for every message class.

The definitions of ROS's own types come with the ``rosbags`` library; those of other dataclasses are derived
from their fields. Only this module uses the library.
"""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from operator import attrgetter
from types import SimpleNamespace
from typing import Any, Final, cast, get_args, get_origin, get_type_hints

import numpy as np
from rosbags.interfaces import Msgdef, Nodetype
from rosbags.interfaces.typing import Typesdict
from rosbags.serde import SerdeError, cdr, ros1
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import Typestore

from nrp_core.errors import TopicError
from nrp_core.messages.base import message_classes, type_name, type_of

_parsed = lru_cache(maxsize=1024)(get_types_from_msg)
"""The types in a definition, by its text and name; recordings repeat those of each other."""


class LazyTypestore(Typestore):
    """A type store with the types of a release of ROS, which compiles a function when it is first used.

    The library compiles fifteen functions of a type together, which took 0.15 s of the start of a recording
    that needs three of them.

    Args:
        known: the release.
    """

    def __init__(self, known: Stores) -> None:
        super().__init__()
        base = get_typestore(known)
        self.fielddefs.update(base.fielddefs)
        self.types.update(base.types)

    def register(self, typs: Typesdict) -> None:
        """Add types; those that are already known are not compiled again.

        Raises:
            TypesysError: a type is known with other fields.
        """
        super().register({name: one for name, one in typs.items() if not self._knows(name, one[1])})

    def _knows(self, name: str, fields: Any) -> bool:
        return name in self.fielddefs and self.fielddefs[name][1] == fields

    def hash_rihs01(self, typ: str) -> str:
        """Return the hash of a type; in ROS 2 a ``char`` is a ``uint8``, which the library does not know."""
        store = Typestore()
        for name, (constants, fields) in self.fielddefs.items():
            store.fielddefs[name] = constants, [(field, _without_char(kind)) for field, kind in fields]
        return store.hash_rihs01(typ)

    def deserialize_cdr(self, rawdata: bytes | memoryview, typename: str) -> object:
        """Return a message. ROS's own encoder may append bytes without a meaning, which are ignored.

        Raises:
            SerdeError: the bytes are not such a message.
        """
        if bytes(rawdata[:2]) not in (b"\x00\x00", b"\x00\x01"):
            raise SerdeError("they do not begin as encoded data of ROS 2 do")
        functions = self.get_msgdef(typename)
        decode = functions.deserialize_cdr_le if rawdata[1] else functions.deserialize_cdr_be
        try:
            return decode(rawdata[4:], 0, functions.cls, self)[0]
        except (struct.error, UnicodeDecodeError, ValueError) as error:
            raise SerdeError(str(error)) from error

    def get_msgdef(self, typename: str) -> Msgdef[object]:
        """Return the functions of a type."""
        found = self.cache.get(typename)
        if found is None:
            found = self.cache[typename] = cast("Msgdef[object]", _Functions(typename, self))
        return found


class _Functions:
    """The functions of one type under the names of the library's ``Msgdef``."""

    def __init__(self, name: str, store: Typestore) -> None:
        self.name, self._store = name, store
        self.fields = [(normalize_fieldname(field), kind) for field, kind in store.fielddefs[name][1]]
        self.cls = store.types[name]

    def __getattr__(self, name: str) -> Any:
        """Compile a function, or find a size, when it is first used."""
        for names, generate in _GENERATORS.items():
            if name in names:
                vars(self).update(zip(names, generate(self.fields, self._store), strict=True))
                return vars(self)[name]
        raise AttributeError(name)


_GENERATORS: Final[dict[tuple[str, ...], Callable[..., tuple[Any, ...]]]] = {
    ("getsize_cdr", "size_cdr"): cdr.generate_getsize_cdr,
    ("getsize_ros1", "size_ros1"): ros1.generate_getsize_ros1,
    ("serialize_cdr_le",): lambda fields, store: (cdr.generate_serialize_cdr(fields, store, "le"),),
    ("deserialize_cdr_le",): lambda fields, store: (cdr.generate_deserialize_cdr(fields, store, "le"),),
    ("deserialize_cdr_be",): lambda fields, store: (cdr.generate_deserialize_cdr(fields, store, "be"),),
    ("serialize_ros1",): lambda fields, store: (ros1.generate_serialize_ros1(fields, store),),
    ("deserialize_ros1",): lambda fields, store: (ros1.generate_deserialize_ros1(fields, store),),
}
"""What the library's generators make of the fields of a type."""


PACKAGE = "nrp_msgs"
"""The package of message classes without one."""

_SCALARS = {float: "float64", int: "int64", bool: "bool", str: "string"}

_FILLER = "structure_needs_at_least_one_member"
"""The field of messages without one."""
_EMPTY = SimpleNamespace(**{_FILLER: 0})
_HEAD = b"\x00\x01\x00\x00"
_CODES = {
    "bool": "?", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H",
    "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip

Prepare = Callable[[Any], Any]


@dataclasses.dataclass(frozen=True, slots=True)
class MessageField:
    """A field in the definition of a message.

    Args:
        name: the name of the field.
        type: the type of its value or items: ``float64``, ``string``, ... or ``package/msg/Type``.
        many: whether it holds a variable number of items.
        most: the maximum number; 0: unlimited.
        length: the fixed number of items; None: a single value, or ``many``.
    """

    name: str
    type: str
    many: bool = False
    most: int = 0
    length: int | None = None


class Codec:
    """Encodes and decodes messages.

    Args:
        definitions: texts of type definitions by type name, as a recording holds them; then no other types
            are known. By default the types of ROS 2.
    """

    _known_types = Stores.ROS2_JAZZY

    def __init__(self, definitions: Mapping[str, str] | None = None) -> None:
        self._store = LazyTypestore(self._known_types if definitions is None else Stores.EMPTY)
        self._prepare: dict[str, Prepare | None] = {}
        self._packers: dict[type, Callable[[Any], bytes] | None] = {}
        self._names: dict[type, str] = {}
        self._given: set[str] = set()
        for name, text in (definitions or {}).items():
            self.define(name, text)

    def define(self, name: str, text: str) -> None:
        """Add a type by its definition, which includes the texts of the types in it."""
        if name in self._given:
            return
        self._given.add(name)
        self._store.register(_parsed(text, name))
        self._adopt(name)

    def compose(self, name: str, fields: Sequence[MessageField], like: str | None = None) -> None:
        """Add or replace a type by its fields, with the constants of a type ``like`` it.

        Unlike in :meth:`define`, the name may be that of a part of a service or action.
        """
        constants = [] if like is None else self._store.fielddefs[like][0]
        self._store.fielddefs.pop(name, None)
        self._store.register({name: (constants, [(field.name, _field_kind(field)) for field in fields])})

    def name(self, cls: type) -> str:
        """Return the full type name of a message class.

        Raises:
            TopicError: one of its fields cannot be encoded, or it differs from ROS's type of that name.
        """
        if cls not in self._names:
            name = type_name(cls)
            self._names[cls] = name if "/" in name else f"{PACKAGE}/msg/{name}"
            self._compile(cls)
        return self._names[cls]

    def names(self) -> list[str]:
        """Return the names of all types: its own, and those of the loaded message classes."""
        for cls in message_classes():
            with suppress(TopicError):  # reported when it is used
                self.name(cls)
        return sorted(self._store.fielddefs)

    def definition(self, name: str) -> str:
        """Return the text that defines a type, in the format that recordings hold (``ros2msg``)."""
        return self._store.generate_msgdef(name, ros_version=2)[0]

    def fields(self, name: str) -> list[MessageField]:
        """Return the fields of a type in order; an empty message has a padding field."""
        return [_message_field(field, kind) for field, kind in self._store.fielddefs[name][1]]

    def constants(self, name: str) -> dict[str, Any]:
        """Return the constants of a type."""
        return {constant: value for constant, _, value in self._store.fielddefs[name][0]}

    def hash(self, name: str) -> str:
        """Return the hash by which ROS 2 compares types (REP 2011)."""
        return self._store.hash_rihs01(name)

    def encode(self, message: Any) -> memoryview:
        """Return a message as bytes.

        Raises:
            TopicError: a value does not fit the type of its field.
        """
        cls = type(message)
        if cls not in self._packers:
            self._packers[cls] = self._fast(self.name(cls))
        pack = self._packers[cls]
        if pack is None:
            return self.encode_as(message, self.name(cls))
        try:
            return memoryview(pack(message))
        except (struct.error, AttributeError, TypeError, ValueError) as error:
            raise _refused(message, self.name(cls), error) from error

    def encode_as(self, message: Any, name: str) -> memoryview:
        """Return any object with the fields of a type as bytes.

        Raises:
            TopicError: a value does not fit the type of its field.
        """
        try:
            prepare = self._prepare_of(name)
            return self._serialize(message if prepare is None else prepare(message), name)
        except (SerdeError, struct.error, AttributeError, TypeError, ValueError) as error:
            raise _refused(message, name, error) from error

    def decode(self, data: bytes | memoryview, name: str) -> Any:
        """Return the message in ``data``, of our class of that name if it exists.

        Raises:
            TopicError: the bytes are not such a message.
        """
        cls = type_of(name)
        if cls is not None and name in self._store.fielddefs and not self._field_names_of(name):
            return cls()
        try:
            return self._deserialize(data, name)
        except (SerdeError, KeyError, TypeError) as error:
            raise TopicError(f"these {len(data)} bytes are not a {name}: {error}") from error

    # -- the encoding itself

    def _fast(self, name: str) -> Callable[[Any], bytes] | None:
        """Return an encoder of a type that is faster than the library's, if any."""
        numbers = self._numbers(name)
        return _packer(numbers) if numbers else None

    def _serialize(self, message: Any, name: str) -> memoryview:
        return self._store.serialize_cdr(message, name)

    def _deserialize(self, data: bytes | memoryview, name: str) -> Any:
        return self._store.deserialize_cdr(data, name)

    # -- adding types

    def _compile(self, cls: type) -> None:
        name = self._names[cls]
        if name not in self._store.fielddefs:
            theirs = {ours: given for given, ours in self._renamed(name).items()}
            lines = [
                f"{_type_text(hint, cls, self.name)} {theirs.get(field, field)}"
                for field, hint in _fields(cls)
            ]
            text = getattr(cls, "__definition__", "") or "\n".join(lines)
            try:
                self._store.register(_parsed(text, name))
            except TypesysError as error:
                raise TopicError(f"{cls.__name__} cannot be a message: {error}") from error
        has, needs = _field_names(cls), self._field_names_of(name)
        if has != needs:
            raise TopicError(f"{cls.__name__} has the fields {has}, but {name} has {needs}")
        self._adopt(name)
        self._decode_into(name, cls)

    def _renamed(self, name: str) -> Mapping[str, str]:
        """Return the names in our class of fields that the definition of a type spells otherwise."""
        return {}

    def _decode_into(self, name: str, cls: type) -> None:
        self._store.types[name] = cls

    def _adopt(self, name: str) -> None:
        """Decode a type, and those in it, into our classes if these have the defined fields."""
        cls = type_of(name)
        if cls is not None and _field_names(cls) == self._field_names_of(name):
            self._decode_into(name, cls)
        for _, kind in self._store.fielddefs[name][1]:
            inner = _inner_type(kind)
            if inner is not None:
                self._adopt(inner)

    def _field_names_of(self, name: str) -> list[str]:
        renamed = self._renamed(name)
        return [renamed.get(field, field) for field, _ in self._store.fielddefs[name][1] if field != _FILLER]

    # -- conversion for the library, which takes flat NumPy arrays of the right type

    def _prepare_of(self, name: str) -> Prepare | None:
        if name not in self._prepare:
            fields, renamed = self._store.fielddefs[name][1], self._renamed(name)
            prepare = [
                (field, renamed.get(field, field), self._prepare_field(kind)) for field, kind in fields
            ]
            needed = any(field != ours or function is not None for field, ours, function in prepare)
            self._prepare[name] = _rebuild(prepare) if needed else None
            if not self._field_names_of(name):
                self._prepare[name] = lambda _message: _EMPTY
        return self._prepare[name]

    def _numbers(self, name: str, path: str = "") -> list[tuple[str, str]] | None:
        """Return path and type of every number in a message of numbers only; None for other messages."""
        found: list[tuple[str, str]] = []
        for field, (node, what) in self._store.fielddefs[name][1]:
            if node == Nodetype.NAME:
                inner = self._numbers(str(what), f"{path}{field}.")
            else:
                inner = [(f"{path}{field}", what[0])] if node == Nodetype.BASE and what[0] in _CODES else None
            if inner is None:
                return None
            found += inner
        return found

    def _prepare_field(self, kind: Any) -> Prepare | None:
        node, what = kind
        inner = _inner_type(kind)
        prepare = None if inner is None else self._prepare_of(inner)
        if node in (Nodetype.NAME, Nodetype.BASE):
            return prepare
        if inner is None:
            base = what[0][1][0]
            return None if base == "string" else _flat_array(base)
        return None if prepare is None else lambda items: [prepare(item) for item in items]


def _refused(message: Any, name: str, error: Exception) -> TopicError:
    return TopicError(f"this {name} cannot be encoded: {error}; it is {message!r:.200}")


def _packer(numbers: Sequence[tuple[str, str]]) -> Callable[[Any], bytes]:
    """Return an encoder of a message of these numbers, several times as fast as the library.

    In CDR the offset of each number is a multiple of its size.
    """
    if numbers[0][0] == _FILLER:
        return lambda _message: _HEAD + bytes(1)
    layout, size = "<4s", 0
    for _, base in numbers:
        width = struct.calcsize(_CODES[base])
        layout += f"{-size % width}x{_CODES[base]}"
        size += -size % width + width
    pack = struct.Struct(layout).pack
    paths = [path for path, _ in numbers]
    values = attrgetter(*paths)
    if len(paths) == 1:
        return lambda message: pack(_HEAD, values(message))
    return lambda message: pack(_HEAD, *values(message))


def _message_field(name: str, kind: Any) -> MessageField:
    node, what = kind
    if node not in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return MessageField(name, what if node == Nodetype.NAME else what[0])
    (inner, content), count = what
    held = content if inner == Nodetype.NAME else content[0]
    if node == Nodetype.ARRAY:
        return MessageField(name, held, length=count)
    return MessageField(name, held, many=True, most=count)


def _without_char(kind: Any) -> Any:
    node, what = kind
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return node, (_without_char(what[0]), what[1])
    return (node, ("uint8", 0)) if what == ("char", 0) else kind


def _field_kind(field: MessageField) -> Any:
    """Return a field's type as the library writes it."""
    node = (Nodetype.NAME, field.type) if "/" in field.type else (Nodetype.BASE, (field.type, 0))
    if field.length is not None:
        return Nodetype.ARRAY, (node, field.length)
    return (Nodetype.SEQUENCE, (node, field.most)) if field.many else node


def _inner_type(kind: Any) -> str | None:
    """Return the message type in a field, single or list; None for numbers and strings."""
    node, what = kind
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        node, what = what[0]
    return str(what) if node == Nodetype.NAME else None


@lru_cache(maxsize=1024)
def _fields(cls: type) -> list[tuple[str, Any]]:
    if not dataclasses.is_dataclass(cls):
        raise TopicError(f"{cls.__name__} cannot be a message: it is not a dataclass")
    hints = get_type_hints(cls)
    return [(field.name, hints[field.name]) for field in dataclasses.fields(cls)]


def _field_names(cls: type) -> list[str]:
    return [name for name, _ in _fields(cls)]


def _type_text(hint: Any, cls: type, name_of: Callable[[type], str]) -> str:
    """Return a field's type as a ROS definition spells it."""
    if hint in _SCALARS:
        return _SCALARS[hint]
    if hint is bytes:
        return "uint8[]"
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        return name_of(hint)
    origin, args = get_origin(hint), get_args(hint)
    if origin is np.ndarray:
        return f"{np.dtype(get_args(args[1])[0]).name}[]"
    if origin is list or (origin is tuple and args[1:] == (...,)):
        return f"{_type_text(args[0], cls, name_of)}[]"
    raise TopicError(
        f"{cls.__name__} cannot be a message: it has a field of type {hint}; a message holds float, int, "
        "bool, str, bytes, NumPy arrays, other messages and lists of these"
    )


def _flat_array(base: str) -> Prepare:
    dtype = np.dtype({"byte": "uint8", "char": "uint8"}.get(base, base))

    def prepare(value: Any) -> Any:
        if type(value) is np.ndarray and value.dtype is dtype and value.ndim == 1 and value.flags.contiguous:
            return value
        if isinstance(value, (bytes, bytearray, memoryview)):
            return np.frombuffer(value, dtype)
        if dtype == np.uint8 and isinstance(value, np.ndarray) and value.dtype.kind == "f":
            return np.ascontiguousarray(value).reshape(-1).view(np.uint8)  # depths: the bytes of each number
        return np.ascontiguousarray(value, dtype).reshape(-1)

    return prepare


def _rebuild(fields: Sequence[tuple[str, str, Prepare | None]]) -> Prepare:
    """Return a function that rebuilds a message, from each field's name in the library and in our class."""

    def rebuilt(message: Any) -> Any:
        return SimpleNamespace(**{
            name: getattr(message, ours) if function is None else function(getattr(message, ours))
            for name, ours, function in fields
        })  # fmt: skip

    return rebuilt
