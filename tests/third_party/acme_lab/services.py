"""A service: the mass of a model."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_core.messages import message
from nrp_core.world import Service, World


@message("acme_msgs/srv/WeighRequest")
@dataclass(slots=True)
class WeighRequest:
    """The mass of a model."""

    model: str = ""


@message("acme_msgs/srv/WeighResponse")
@dataclass(slots=True)
class WeighResponse:
    """The mass, kg."""

    mass: float = 0.0


def services(world: World) -> list[Service]:
    """Return the services of a world."""

    def weigh(request: WeighRequest) -> WeighResponse:
        links = world.scene.model(request.model).links
        return WeighResponse(sum(link.inertial.mass for link in links if link.inertial))

    return [Service("/acme/weigh", WeighRequest, weigh)]
