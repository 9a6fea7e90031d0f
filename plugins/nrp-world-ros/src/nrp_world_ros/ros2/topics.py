"""DDS topics that can be created while other nodes come and go.

Cyclone DDS for Python describes a type to its C library each time that it creates a topic. For that, version
11.0.1 walks the library's tree of types without the lock of the tree (``ddsi_topic_descriptor_from_type``).
The library's threads change the tree as other nodes come and go, so the process can end with a segmentation
fault. Here each type is described once for a domain, while nothing arrives from others.
"""

from __future__ import annotations

import ctypes
import time
import weakref
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from nrp_core.world.messages.cdr import Codec

from nrp_world_ros.ros2.types import DdsTypes

_LATE_S = 0.05
"""Time in which DDS finishes with all that has arrived, s."""

_FOR_EVER = (1 << 63) - 1
_Described = tuple[ctypes.c_void_p, type[Any]]


class DomainTopics:
    """Creates the topics of one domain in this process.

    Args:
        domain: the domain of DDS, without participants.
        number: its number.
    """

    def __init__(self, domain: Any, number: int) -> None:
        self.domain = domain
        self._number = number
        self._described: dict[tuple[str, str], _Described] = {}
        self._dll = _functions(domain)
        weakref.finalize(self, _forget, self._dll, self._described)  # before the domain ends

    def describe(self, codec: Codec) -> None:
        """Describe the types of a codec; other nodes do not notice this."""
        from cyclonedds.domain import DomainParticipant

        types = DdsTypes(codec)
        with self._isolated(mute=True):
            scribe = DomainParticipant(self._number)
            # kept until the end, because topics that are deleted change the tree too, and later
            _kept = [self._describe(scribe, name, codec, types) for name in codec.names()]

    def topic(self, participant: Any, topic: str, name: str, codec: Codec) -> Any:
        """Return a new topic.

        Args:
            participant: the participant of DDS.
            topic: name of the topic in DDS.
            name: its type.
            codec: knows the type.

        Raises:
            DDSException: DDS does not permit this name.
        """
        from cyclonedds.core import Entity
        from cyclonedds.topic import Topic

        if (name, codec.hash(name)) not in self._described:
            with self._isolated(mute=False):
                time.sleep(_LATE_S)
                self._describe(participant, name, codec, DdsTypes(codec))
        description, kind = self._described[name, codec.hash(name)]
        used = ctypes.c_void_p(self._dll.ddsi_sertype_ref(description))
        handle = self._dll.dds_create_topic_sertype(
            participant._ref, topic.encode(), ctypes.byref(used), None, None, None
        )
        if handle < 0:
            self._dll.ddsi_sertype_unref(used)
        made = Topic.__new__(Topic)
        Entity.__init__(made, handle)
        made.data_type, made._keepalive_entities = kind, [participant]
        return made

    def _describe(self, participant: Any, name: str, codec: Codec, types: DdsTypes) -> Any:
        from cyclonedds.topic import Topic

        kind = types.type(name)
        subject = Topic(participant, f"description of {name}".replace("/", "_").replace(" ", "_"), kind)
        description = ctypes.c_void_p()
        self._dll.dds_get_entity_sertype(subject._ref, ctypes.byref(description))
        self._dll.ddsi_sertype_ref(description)
        self._described[name, codec.hash(name)] = description, kind
        return subject

    @contextmanager
    def _isolated(self, *, mute: bool) -> Iterator[None]:
        """Let nothing arrive from other nodes; what is reliable is sent again."""
        self._dll.dds_domain_set_deafmute(self.domain._ref, True, mute, _FOR_EVER)
        try:
            yield
        finally:
            self._dll.dds_domain_set_deafmute(self.domain._ref, False, False, 0)


def _forget(dll: Any, described: Mapping[tuple[str, str], _Described]) -> None:
    for description, _ in described.values():
        dll.ddsi_sertype_unref(description)


def _functions(domain: Any) -> Any:
    """Return the C library of DDS with the types of the functions that its package for Python lacks."""
    dll, pointer, number = domain._dll_handle, ctypes.c_void_p, ctypes.c_int32
    where = ctypes.POINTER(pointer)
    for function, result, arguments in (
        (dll.dds_domain_set_deafmute, number, [number, ctypes.c_bool, ctypes.c_bool, ctypes.c_int64]),
        (dll.dds_get_entity_sertype, number, [number, where]),
        (dll.ddsi_sertype_ref, pointer, [pointer]),
        (dll.ddsi_sertype_unref, None, [pointer]),
        (dll.dds_create_topic_sertype, number, [number, ctypes.c_char_p, where, pointer, pointer, pointer]),
    ):
        function.restype, function.argtypes = result, arguments
    return dll
