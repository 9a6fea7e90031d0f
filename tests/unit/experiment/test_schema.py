"""The JSON Schema that editors use."""

import json
from typing import Any

import pytest
from golden import Golden

from nrp_core.experiment.reading.reader import experiment_schema

pytestmark = pytest.mark.usefixtures("fakes")


@pytest.fixture
def schema() -> dict[str, Any]:
    return json.loads(json.dumps(experiment_schema()))  # type: ignore[no-any-return]


def options_of(schema: dict[str, Any], section: str, backend: str) -> dict[str, Any]:
    for rule in schema["$defs"][section]["allOf"]:
        if rule["if"]["properties"]["backend"]["const"] == backend:
            return rule["then"]["properties"]["options"]["properties"]  # type: ignore[no-any-return]
    raise AssertionError(f"no options for {backend}")


def test_every_key_is_explained(schema: dict[str, Any]) -> None:
    sections = [schema, *(s for name, s in schema["$defs"].items() if "." not in name)]
    for section in sections:
        for key, value in section.get("properties", {}).items():
            assert value.get("description"), f"{section.get('title')}.{key} says nothing"


def test_options_of_third_party_backends_are_completed_too(schema: dict[str, Any]) -> None:
    assert "resolution" in options_of(schema, "BrainSection", "counting")
    assert options_of(schema, "WorldSection", "disc")["timestep"]["examples"] == ["20 ms"]


def test_installed_backends_are_suggested_and_others_allowed(schema: dict[str, Any]) -> None:
    enum, free = schema["$defs"]["BrainSection"]["properties"]["backend"]["anyOf"]
    assert {"counting", "event"} <= set(enum["enum"])
    assert free == {"type": "string"}


def test_a_backend_that_does_not_load_costs_only_its_own_options(
    schema: dict[str, Any], golden: Golden
) -> None:
    with golden.raises(AssertionError):
        options_of(schema, "BrainSection", "broken")


def test_a_file_that_extends_another_need_not_repeat_it(schema: dict[str, Any]) -> None:
    assert schema["anyOf"] == [
        {"required": ["extends"]},
        {"required": ["name", "duration", "brain", "world"]},
    ]
    assert not any("required" in section for section in schema["$defs"].values())
    named = schema["properties"]["criteria"]["patternProperties"]
    assert all({"type": "null"} in value["anyOf"] for value in named.values())


def test_optional_keys_can_be_removed_by_null(schema: dict[str, Any]) -> None:
    properties = schema["properties"]
    for key in ("events", "aliases", "transfer_functions", "seed", "pace"):
        assert "null" in properties[key]["type"], key
    assert None in properties["on_error"]["enum"]
    assert "null" not in properties["name"]["type"]
    assert "null" in schema["$defs"]["BrainSection"]["properties"]["populations"]["type"]


def test_all_references_lead_somewhere(schema: dict[str, Any]) -> None:
    references = [part.split('"')[0] for part in json.dumps(schema).split('"$ref": "#/$defs/')[1:]]
    assert set(references) <= set(schema["$defs"])
