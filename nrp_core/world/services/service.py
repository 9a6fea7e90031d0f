"""Services: a request and its answer. Packages add theirs by the entry-point group ``nrp_core.services``.

An entry point names a function that takes the :class:`~nrp_core.world.live.LiveScene` of a world and returns
the services that it adds::

    def services(live):
        return [Service("/gazebo/pause_physics", EmptyRequest, pause)]
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias

from nrp_core.registry import Registry
from nrp_core.world.live import LiveScene
from nrp_core.world.messages import base
from nrp_core.world.messages.base import type_name

PREFIX = "/gazebo/"


@dataclass(frozen=True, slots=True)
class Service:
    """A service of a world.

    Args:
        name: its name, which is also the topic that takes its requests.
        request: the class of its requests; the class of its answers has the same name with ``Response``
            instead of ``Request``.
        answer: handles a request and returns the answer; an :class:`~nrp_core.errors.NrpError` becomes an
            answer without success if the answer has a field for the reason.
    """

    name: str
    request: type
    answer: Callable[[Any], Any]

    @property
    def response(self) -> type:
        """The class of its answers."""
        found = base.type_of(type_name(self.request).removesuffix("Request") + "Response")
        assert found is not None
        return found


Provider: TypeAlias = Callable[[LiveScene], Iterable[Service]]

SERVICES: Registry[Provider] = Registry("nrp_core.services", "provider of services")
"""Functions that return the services of a world, by any name."""
