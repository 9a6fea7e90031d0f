"""Classes of ROS services are made from their definitions."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from nrp_core.world.messages.cdr import Codec
from nrp_core.world.messages.gazebo_srvs import GetJointPropertiesResponse, GetModelStateRequest

GENERATOR = runpy.run_path(str(Path(__file__).parents[4] / "scripts" / "generate_services.py"))


@pytest.mark.parametrize("package", GENERATOR["TARGETS"])
def test_the_modules_of_services_are_those_of_their_definitions(package: str) -> None:
    text = (GENERATOR["MESSAGES"] / GENERATOR["TARGETS"][package]).read_text("utf-8")
    assert text == GENERATOR["module"](package), "run scripts/generate_services.py"


def test_the_default_values_of_a_definition_are_those_of_its_class() -> None:
    assert GetModelStateRequest("husky").relative_entity_name == "world"
    assert GetJointPropertiesResponse().success is True


def test_numbers_have_the_size_of_the_definition() -> None:
    codec = Codec()
    name = codec.name(GetJointPropertiesResponse)
    assert codec.fields(name)[0].type == "uint8"
    decoded = codec.decode(codec.encode(GetJointPropertiesResponse(2, [0.5], [1.0])), name)
    assert (decoded.type, list(decoded.damping), list(decoded.position)) == (2, [0.5], [1.0])
