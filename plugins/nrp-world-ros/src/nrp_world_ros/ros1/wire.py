"""Message classes for rospy, for any type, without ROS's message packages.

rospy needs the type of a message, a checksum, the text of its definition, and bytes. The platform's codec has
them all, also for types that are not installed on this machine.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from nrp_core.world.messages.ros1 import Ros1Codec

CODEC = Ros1Codec()


@cache
def wire_type(name: str) -> type[Any]:
    """Return rospy's message class for a type of the codec.

    Args:
        name: the full name, ``package/msg/Type``.
    """
    import genpy

    class Wire(genpy.Message):  # type: ignore[misc]
        """A message as bytes."""

        __slots__ = ["data"]
        _slot_types = ["uint8[]"]  # noqa: RUF012  rospy's own name for what it reads
        _type = name.replace("/msg/", "/")
        _md5sum = CODEC.md5(name)
        _full_text = CODEC.definition(name)
        _has_header = False

        def __init__(self, data: bytes | memoryview = b"") -> None:
            self.data = data

        def serialize(self, buff: Any) -> None:
            buff.write(self.data)

        def deserialize(self, data: bytes) -> Wire:
            self.data = data
            return self

    return Wire


@cache
def wire_service(request: str, response: str) -> type[Any]:
    """Return rospy's class of a service.

    Args:
        request: full name of the request, ``package/msg/NameRequest``.
        response: full name of the response, ``package/msg/NameResponse``.
    """
    content = {
        "_type": request.replace("/msg/", "/").removesuffix("Request"),
        "_md5sum": CODEC.service_md5(request, response),
        "_request_class": wire_type(request),
        "_response_class": wire_type(response),
    }
    return type("WireService", (), content)
