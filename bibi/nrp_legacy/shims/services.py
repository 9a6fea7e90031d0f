"""The services of Gazebo as experiments call them; the world answers."""

from __future__ import annotations

import dataclasses
from typing import Any

from nrp_core.errors import NrpError
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.modules import Request

_SPELLINGS = {"entity_name": "model_name", "entity_xml": "model_xml", "entity_namespace": "robot_namespace"}
"""Fields as the platform's own version of Gazebo called them."""
_UNUSED = ("attenuation_constant", "attenuation_linear", "attenuation_quadratic")
"""Fields of requests that worlds here know nothing of."""


class ServiceException(Exception):  # noqa: N818 - the name that users catch
    """A service does not exist, or cannot do what is asked."""


class Services:
    """Answers calls.

    Args:
        graph: of the run.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def call(self, name: str, *values: Any, **fields: Any) -> Any:
        """Return what a service answers.

        Args:
            name: absolute.
            values: the fields of the request in their order, or one request.
            fields: the fields by name.

        Raises:
            ServiceException: there is no such service, or it cannot do this.
        """
        if not self._graph.has_begun:
            raise ServiceException(f"service {name} is available only while the simulation runs")
        if len(values) == 1 and isinstance(values[0], Request):
            values, fields = values[0].values, {**values[0].fields, **fields}
        if name not in self._graph.world.topics:
            raise ServiceException(f"service {name} is not available")
        known = [field.name for field in dataclasses.fields(self._graph.world.topics[name].type)]
        if any(value is None for value in values):
            fields, values = {**dict(zip(known, values, strict=False)), **fields}, ()
        given = {key: value for key, value in fields.items() if value is not None}
        named = {_SPELLINGS.get(key, key): value for key, value in given.items()}
        try:
            return self._graph.world.call(
                name,
                *values[: max(1, len(known))],
                **{key: value for key, value in named.items() if key in known or key not in _UNUSED},
            )
        except (NrpError, TypeError) as error:
            raise ServiceException(f"service {name}: {error}") from error
