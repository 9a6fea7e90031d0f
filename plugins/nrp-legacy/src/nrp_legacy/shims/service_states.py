"""States that call a service, and those that change the look of the room by one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from nrp_core.clock import from_seconds
from nrp_core.findings import Code
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.meshes.stl import mean_color
from nrp_legacy.shims.graph import Graph, absolute
from nrp_legacy.shims.services import ServiceException, Services
from nrp_legacy.shims.smach import State
from nrp_legacy.shims.steps import Task

_TEXTURES = ("resources/textures", "assets/textures")
"""Where the images of an experiment are."""

SERVED = ("succeeded", "aborted", "preempted")


class CallingState(State):
    """A state that calls services; if one fails, this is reported and the state is aborted.

    Args:
        graph: the graph of the run.
        services: the services of the run.
    """

    def __init__(self, graph: Graph, services: Services) -> None:
        super().__init__(SERVED)
        self._graph, self._services = graph, services

    def _answer(self, name: str, *values: Any, **options: Any) -> Any:
        """Return the answer of a service, or None."""
        try:
            return self._services.call(name, *values, **options)
        except ServiceException as error:
            self._graph.warn(Code.NRP280, str(error))
            return None

    def _outcome(self, name: str, answer: Any) -> str:
        return "aborted" if answer is None or self._services.has_refused(name, answer) else "succeeded"


class ServiceState(CallingState):
    """Calls a service once.

    Args:
        service_name: the service.
        service_spec: its type.
        request: the request; or ``request_cb`` makes it from the user data and an empty request.
        response_cb: called with the user data and the answer; it may return an outcome.
        request_key, response_key: the keys of the request and the answer in the user data.
    """

    def __init__(
        self,
        graph: Graph,
        services: Services,
        service_name: str,
        service_spec: Any = None,
        request: Any = None,
        request_cb: Callable[..., Any] | None = None,
        response_cb: Callable[..., Any] | None = None,
        request_key: str | None = None,
        response_key: str | None = None,
        **_keys: Any,
    ) -> None:
        super().__init__(graph, services)
        self._keys = request_key, response_key
        self._name, self._kind = absolute(service_name), service_spec
        self._request, self._request_cb, self._response_cb = request, request_cb, response_cb

    def execute(self, userdata: Any) -> str:
        request_key, response_key = self._keys
        asked = self._request if request_key is None else userdata[request_key]
        if self._request_cb is not None:
            asked = self._request_cb(userdata, asked)
        answer = self._answer(self._name, *([] if asked is None else [asked]), kind=self._kind)
        if answer is None:
            return "aborted"
        if response_key is not None:
            userdata[response_key] = answer
        chosen = None if self._response_cb is None else self._response_cb(userdata, answer)
        return chosen or self._outcome(self._name, answer)


class SetMaterialColorServiceState(CallingState):
    """Sets the material of a visual; a texture of the experiment is shown in its mean colour."""

    def __init__(
        self,
        graph: Graph,
        services: Services,
        model_name: str,
        link_name: str,
        visual_name: str,
        material_name: str,
        delay: float = 0.0,
        *_keys: Any,
    ) -> None:
        super().__init__(graph, services)
        self._delay_s = float(delay)
        self.values = (model_name, link_name, visual_name, "material:script:name", material_name)

    def execute(self, userdata: Any) -> str:
        task = Task.here()
        if task is not None and self._delay_s > 0:
            task.wait_until(self._graph.now_ns + from_seconds(self._delay_s))
        name, (*visual, _, material) = "/gazebo/set_visual_properties", self.values
        color = self._of_texture(str(material))
        values = self.values if color is None else (*visual, "material:diffuse", color)
        return self._outcome(name, self._answer(name, *values))

    def _of_texture(self, image: str) -> str | None:
        """Return the colour of an image that the experiment has among its textures."""
        places = (folder / below / image for folder in self._graph.folders for below in _TEXTURES)
        found = next((place for place in places if place.suffix and place.is_file()), None)
        mean = mean_color(found.read_bytes()) if found else None
        return None if mean is None else " ".join(map(str, (*mean, 1.0)))


class LightServiceState(CallingState):
    """Sets the colour of a light; parts that are not given stay.

    Args:
        light_name: its name.
        diffuse: red, green, blue and optionally alpha, from 0 to 1, as a list or by ``r``, ``g``, ``b``,
            ``a``.
    """

    def __init__(
        self,
        graph: Graph,
        services: Services,
        light_name: str,
        diffuse: Any = (),
        *attenuation: Any,
        **attenuations: Any,
    ) -> None:
        super().__init__(graph, services)
        self._light, self._diffuse = light_name, diffuse or ()
        if attenuation or attenuations:
            message = "a state that sets a light sets its colour; its attenuation stays"
            graph.warn(Code.NRP216, message, subject=light_name)

    def execute(self, userdata: Any) -> str:
        now = self._answer("/gazebo/get_light_properties", self._light)
        if now is None or not now.success:
            return self._outcome("/gazebo/get_light_properties", now)
        name = "/gazebo/set_light_properties"
        return self._outcome(name, self._answer(name, self._light, _color(self._diffuse, now.diffuse)))


def _color(given: Any, now: ColorRGBA) -> ColorRGBA:
    """Return a colour that is given in any form; parts that are not given are as before."""
    parts = given if isinstance(given, Mapping) else dict(zip("rgba", given, strict=False))
    return ColorRGBA(*(float(parts.get(part, getattr(now, part))) for part in "rgba"))
