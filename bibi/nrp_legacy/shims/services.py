"""The services of Gazebo that a world of ours can answer."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from nrp_core.errors import NrpError
from nrp_core.world.messages.geometry_msgs import Pose, Twist
from nrp_core.world.messages.std_msgs import ColorRGBA
from nrp_core.world.parts.model_states import MODEL_STATES
from nrp_core.world.scene.materials import color_of
from nrp_legacy.shims.graph import Graph
from nrp_legacy.shims.modules import Request


class ServiceException(Exception):  # noqa: N818 - the name that users catch
    """A service is not there, or does not do what is asked."""


class Services:
    """Answers calls.

    Args:
        graph: of the run.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._answers: dict[str, tuple[tuple[str, ...], Callable[..., Any]]] = {
            "/gazebo/get_model_state": (("model_name", "relative_entity_name"), self._model_state),
            "/gazebo/get_world_properties": ((), self._world_properties),
            "/gazebo/set_visual_properties": (
                ("model_name", "link_name", "visual_name", "property_name", "property_value"),
                self._visual_properties,
            ),
        }

    def call(self, name: str, *values: Any, **fields: Any) -> Any:
        """Return what a service answers.

        Args:
            name: absolute.
            values: the fields of the request in their order, or one request.
            fields: the fields by name.

        Raises:
            ServiceException: there is no such service, or it cannot do this.
        """
        if name not in self._answers:
            raise ServiceException(f"service {name} is not available")
        if not self._graph.has_begun:
            raise ServiceException(f"service {name} answers once the simulation runs")
        if len(values) == 1 and isinstance(values[0], Request):
            values, fields = values[0].values, {**values[0].fields, **fields}
        names, answer = self._answers[name]
        given = {**dict(zip(names, values, strict=False)), **fields}
        try:
            return answer(**{field: value for field, value in given.items() if field in names})
        except (NrpError, TypeError) as error:
            raise ServiceException(f"service {name}: {error}") from error

    def _model_state(self, model_name: str, relative_entity_name: str = "world") -> SimpleNamespace:
        states = self._graph.latest(MODEL_STATES)
        if model_name not in states.name:
            message = f"no model '{model_name}'"
            return SimpleNamespace(pose=Pose(), twist=Twist(), success=False, status_message=message)
        i = states.name.index(model_name)
        return SimpleNamespace(pose=states.pose[i], twist=states.twist[i], success=True, status_message="")

    def _world_properties(self) -> SimpleNamespace:
        names = self._graph.latest(MODEL_STATES).name
        return SimpleNamespace(sim_time=self._graph.now_s, model_names=names, success=True)

    def _visual_properties(
        self,
        model_name: str,
        link_name: str,
        visual_name: str,
        property_name: str = "",
        property_value: str = "",
    ) -> SimpleNamespace:
        topic = f"/{model_name}/{link_name}/{visual_name}/color"
        self._graph.world.advertise(topic).publish(ColorRGBA(*color_of(property_value)))
        return SimpleNamespace(success=True, status_message="")
