"""Message classes as rospy wants them, for any type, without ROS's message packages.

rospy needs to know of a message its type, a check sum, the text of its definition, and bytes. The platform's
codec has them all, also for types that no ROS package on this machine has.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from nrp_core.world.messages.ros1 import Ros1Codec

CODEC = Ros1Codec()


@cache
def wire_type(name: str) -> type[Any]:
    """Return rospy's message class for a type that the codec knows.

    Args:
        name: the full name, ``package/msg/Type``.
    """
    import genpy

    class Wire(genpy.Message):  # type: ignore[misc]
        """A message that is not looked into."""

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
        request: full name of one of its messages, ``package/msg/NameRequest``.
        response: that of the other, ``package/msg/NameResponse``.
    """
    content = {
        "_type": request.replace("/msg/", "/").removesuffix("Request"),
        "_md5sum": CODEC.service_md5(request, response),
        "_request_class": wire_type(request),
        "_response_class": wire_type(response),
    }
    return type("WireService", (), content)
