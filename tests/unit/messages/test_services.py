"""Classes of ROS services have the defaults and sizes of their definitions."""

from __future__ import annotations

from nrp_core.messages.cdr import Codec
from nrp_core.messages.gazebo_srvs import GetJointPropertiesResponse, GetModelStateRequest


def test_the_default_values_of_a_definition_are_those_of_its_class() -> None:
    assert GetModelStateRequest("husky").relative_entity_name == "world"
    assert GetJointPropertiesResponse().success is True


def test_numbers_have_the_size_of_the_definition() -> None:
    codec = Codec()
    name = codec.name(GetJointPropertiesResponse)
    assert codec.fields(name)[0].type == "uint8"
    decoded = codec.decode(codec.encode(GetJointPropertiesResponse(2, [0.5], [1.0])), name)
    assert (decoded.type, list(decoded.damping), list(decoded.position)) == (2, [0.5], [1.0])
