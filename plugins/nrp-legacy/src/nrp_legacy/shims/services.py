"""Services as experiments call them: the world answers those of Gazebo, experiments those that they serve."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, Final

from nrp_core.errors import NrpError
from nrp_core.findings import Code
from nrp_core.messages import gazebo_srvs, std_srvs
from nrp_core.messages.geometry_msgs import Vector3
from nrp_legacy.shims.graph import Graph, absolute
from nrp_legacy.shims.modules import OpenMessage, Request, with_numbers

_SPELLINGS = {"entity_name": "model_name", "entity_xml": "model_xml", "entity_namespace": "robot_namespace"}
"""Fields as the platform's own version of Gazebo called them."""
_UNUSED = ("attenuation_constant", "attenuation_linear", "attenuation_quadratic")
"""Fields of requests that worlds here know nothing of."""
_SAME: Final = {"SpawnEntity": "SpawnModel", "DeleteEntity": "DeleteModel"}
"""Types of the platform's own version of Gazebo."""

_ACTING = ("apply_", "set_", "spawn_")
"""How the names of services begin that change something; others may ask whether a thing is there."""


@dataclasses.dataclass(slots=True)
class SizedModelState(gazebo_srvs.GetModelStateResponse):
    """The state of a model with its size, which the platform's version of Gazebo added."""

    scale: Vector3 = dataclasses.field(default_factory=lambda: Vector3(1.0, 1.0, 1.0))


class ServiceException(Exception):  # noqa: N818 - the name that users catch
    """A service does not exist, or the request failed."""


class Service:
    """A service that an experiment serves; calls are answered at once, where they are made.

    Args:
        services: all services of the experiment.
        name: its name.
        service_class: its type.
        handler: called with the request; returns the answer, or its fields as a list, tuple, dictionary or
            single value.

    Attributes:
        kind: the name of its type; empty if the type has none.
    """

    def __init__(
        self,
        services: Services,
        name: str,
        service_class: Any,
        handler: Callable[[Any], Any],
        *_values: Any,
        **_options: Any,
    ) -> None:
        self._services, self.resolved_name = services, absolute(name)
        self.kind, self._handler = str(getattr(service_class, "name", "")), handler
        services.served[self.resolved_name] = self

    def answer(self, values: tuple[Any, ...], fields: dict[str, Any]) -> Any:
        """Return the answer to a call.

        Raises:
            ServiceException: the request does not fit, or the handler raised or returned nothing.
        """
        name = self.resolved_name
        if len(values) == 1 and dataclasses.is_dataclass(values[0]) and not fields:
            request = values[0]
        else:
            request = self._message("Request", values, fields)
        try:
            answer = self._handler(request)
        except Exception as error:
            raise ServiceException(
                f"service {name}: its handler raised {type(error).__name__}: {error}"
            ) from error
        if answer is None:
            raise ServiceException(f"service {name}: its handler returned None instead of an answer")
        if isinstance(answer, Request):
            return self._message("Response", answer.values, answer.fields)
        if isinstance(answer, (list, tuple)):
            return self._message("Response", tuple(answer), {})
        if isinstance(answer, dict):
            return self._message("Response", (), answer)
        is_message = dataclasses.is_dataclass(answer) or isinstance(answer, OpenMessage)
        return answer if is_message else self._message("Response", (answer,), {})

    def _message(self, end: str, values: tuple[Any, ...], fields: dict[str, Any]) -> Any:
        """Return a request or an answer.

        Raises:
            ServiceException: its fields are other ones, or values are without names and so are the fields.
        """
        name = f"{self.kind}{end}"
        known = next((getattr(one, name) for one in (std_srvs, gazebo_srvs) if hasattr(one, name)), None)
        try:
            if known is not None:
                return known(*values, **fields)
        except TypeError as error:
            raise ServiceException(f"service {self.resolved_name}: {error}") from error
        if values:
            raise ServiceException(
                f"service {self.resolved_name}: the fields of {name} are not known here: name them, as in "
                f"{name}(field={values[0]!r})"
            )
        return OpenMessage(**fields)

    def shutdown(self, *_reason: Any) -> None:
        """Stop serving."""
        self._services.served.pop(self.resolved_name, None)

    def spin(self) -> None:
        """Do nothing, because calls are answered at once."""


class Services:
    """Answers calls.

    Args:
        graph: the graph of the run.

    Attributes:
        served: the services that the experiment itself serves, by name.
        beyond: those of the script that runs the experiment, or of the experiment that a script runs.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self.served: dict[str, Service] = {}
        self.beyond: dict[str, Service] = {}

    def _own(self, name: str) -> Service | None:
        """Return a service that is not one of the world."""
        return self.served.get(name) or self.beyond.get(name)

    def call(self, name: str, *values: Any, kind: Any = None, **fields: Any) -> Any:
        """Return the answer of a service.

        Args:
            name: the absolute name.
            kind: the type of service that the caller expects; None: any.
            values: the fields of the request in their order, or one request.
            fields: the fields by name.

        Raises:
            ServiceException: the service does not exist, it is of another type, or the request failed.
        """
        self._require(name, kind)
        if len(values) == 1 and isinstance(values[0], Request):
            values, fields = values[0].values, {**values[0].fields, **fields}
        own = self._own(name)
        if own is not None:
            return own.answer(values, fields)
        if not self._graph.has_begun:
            raise ServiceException(f"service {name} is available only while the simulation runs")
        if name not in self._graph.world.topics:
            raise ServiceException(f"service {name} is not available")
        request = dataclasses.fields(self._graph.world.topics[name].type)
        known = [field.name for field in request]
        lists = {field.name for field in request if str(field.type).startswith("list")}
        if any(value is None for value in values):
            fields, values = {**dict(zip(known, values, strict=False)), **fields}, ()
        given = {_SPELLINGS.get(key, key): value for key, value in fields.items() if value is not None}
        named = {key: value if key in lists else with_numbers(value) for key, value in given.items()}
        pairs = zip(known or [""], values, strict=False)
        try:
            answer = self._graph.world.call(
                name,
                *(value if key in lists else with_numbers(value) for key, value in pairs),
                **{key: value for key, value in named.items() if key in known or key not in _UNUSED},
            )
        except (NrpError, TypeError) as error:
            raise ServiceException(f"service {name}: {error}") from error
        if name.rpartition("/")[2].startswith(_ACTING):
            self.has_refused(name, answer)
        if isinstance(answer, gazebo_srvs.GetModelStateResponse):
            first = next(iter(values), "")
            model = named.get("model_name", getattr(first, "model_name", first))
            size = Vector3(*self._graph.scales.get(model, (1.0, 1.0, 1.0)))
            known_fields = {field.name: getattr(answer, field.name) for field in dataclasses.fields(answer)}
            return SizedModelState(**known_fields, scale=size)
        return answer

    def has_refused(self, name: str, answer: Any) -> bool:
        """Return whether an answer is a refusal, which is reported once."""
        if getattr(answer, "success", True):
            return False
        reason = getattr(answer, "status_message", "no success")
        self._graph.warn(Code.NRP280, f"service {name}: {reason}")
        return True

    def _require(self, name: str, kind: Any) -> None:
        """Check the type that a caller expects, as ROS does when a caller connects.

        Raises:
            ServiceException: the service is of another type.
        """
        expected = getattr(kind, "name", getattr(kind, "__name__", ""))
        own = self._own(name)
        if own is not None:
            actual = own.kind
        else:
            info = self._graph.world.topics.get(name) if self._graph.has_begun else None
            actual = info.type.__name__.removesuffix("Request") if info and info.response else ""
        if expected and actual and _SAME.get(expected, expected) != actual:
            raise ServiceException(f"service {name} is of type {actual}, not {expected}")
