"""Services are found by entry points: ours and those of other packages by the same door."""

from collections.abc import Callable

from golden import Golden

from nrp_core.dsl.testing import MockWorld
from nrp_core.errors import BackendLoadError, TopicError
from nrp_core.messages.gazebo_srvs import GetWorldPropertiesResponse
from nrp_core.messages.std_srvs import SetBoolRequest, SetBoolResponse
from nrp_core.world import Scene
from nrp_core.world.world import SERVICES

COUNTING = """
from nrp_core.world import Service
from nrp_core.messages.gazebo_srvs import GetWorldPropertiesRequest, GetWorldPropertiesResponse


def services(live):
    def count(request):
        names = [model.name for model in live.scene.models]
        return GetWorldPropertiesResponse(sim_time=float(len(names)), model_names=names)

    return [Service("{name}", GetWorldPropertiesRequest, count)]
"""

Install = Callable[..., None]


def test_our_services_come_by_entry_points_like_any_other() -> None:
    assert {provider.name for provider in SERVICES.providers()} >= {"bodies", "physics", "scenes"}


def test_a_package_adds_a_service_by_an_entry_point(install: Install) -> None:
    install("lab", "[nrp_core.services]\ncounting = lab:services\n", COUNTING.format(name="/lab/count"))
    with MockWorld({}, scene=Scene(())) as world:
        assert world.topics["/lab/count"].response is GetWorldPropertiesResponse
        assert world.call("/lab/count").sim_time == 0.0
        assert world.call("/gazebo/get_world_properties").success


def test_a_second_service_of_the_same_name_is_refused_with_its_provider(
    install: Install, golden: Golden
) -> None:
    install(
        "lab2", "[nrp_core.services]\nzoo = lab2:services\n", COUNTING.format(name="/gazebo/pause_physics")
    )
    with golden.raises(TopicError, match="'zoo'.*'/gazebo/pause_physics'"):
        MockWorld({}, scene=Scene(()))


def test_a_provider_that_does_not_import_is_named(install: Install, golden: Golden) -> None:
    install("lab3", "[nrp_core.services]\nbroken = no_such_module:services\n")
    with golden.raises(BackendLoadError, match="'broken'.*lab3"):
        MockWorld({}, scene=Scene(()))


SWITCHING = """
from nrp_core.errors import SceneError
from nrp_core.world import Service
from nrp_core.messages.std_srvs import SetBoolRequest, SetBoolResponse


def services(live):
    def switch(request):
        if request.data:
            raise SceneError("the lamp is broken")
        return SetBoolResponse(message="off")

    return [Service("/lab/lamp", SetBoolRequest, switch)]
"""


def test_a_standard_service_says_why_it_failed_in_the_field_of_std_srvs(install: Install) -> None:
    install("lab4", "[nrp_core.services]\nlamp = lab4:services\n", SWITCHING)
    with MockWorld({}, scene=Scene(())) as world:
        assert world.call("/lab/lamp", False) == SetBoolResponse(True, "off")
        assert world.call("/lab/lamp", True) == SetBoolResponse(False, "the lamp is broken")
        world.advertise("/lab/lamp").publish(SetBoolRequest(True))
        assert "/lab/lamp: the lamp is broken" in world.warnings
