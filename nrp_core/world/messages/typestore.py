"""The type store of the ``rosbags`` library, which compiles a function of a type when it is first used.

The library compiles all functions of a type together: sizes, both directions, both byte orders, ROS 1, and
conversions between versions. A recording needs three of these fifteen; all of them took 0.15 s of its start.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import lru_cache
from typing import Any, Final, cast

from rosbags.interfaces import Msgdef
from rosbags.interfaces.typing import Typesdict
from rosbags.serde import SerdeError, cdr, ros1
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import Typestore

parsed = lru_cache(maxsize=1024)(get_types_from_msg)
"""The types in a definition, by its text and name; recordings repeat those of each other."""


class LazyTypestore(Typestore):
    """A type store with the types of a release of ROS.

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
