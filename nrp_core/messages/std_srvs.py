"""Services of ROS package std_srvs as pairs of messages, a request and a response; SI units."""

from __future__ import annotations

from nrp_core.messages.base import message


@message("std_srvs/msg/EmptyRequest")
class EmptyRequest:
    """A request without data."""


@message("std_srvs/msg/EmptyResponse")
class EmptyResponse:
    """The answer to :class:`EmptyRequest`."""


@message("std_srvs/msg/SetBoolRequest")
class SetBoolRequest:
    """Switch something on or off."""

    data: bool = False


@message("std_srvs/msg/SetBoolResponse")
class SetBoolResponse:
    """The answer to :class:`SetBoolRequest`."""

    success: bool = True
    message: str = ""


@message("std_srvs/msg/TriggerRequest")
class TriggerRequest:
    """A request without data."""


@message("std_srvs/msg/TriggerResponse")
class TriggerResponse:
    """The answer to :class:`TriggerRequest`."""

    success: bool = True
    message: str = ""
