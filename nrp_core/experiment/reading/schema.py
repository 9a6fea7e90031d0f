"""The experiment file as a JSON Schema, for editors: completion, help and checks while writing."""

from __future__ import annotations

from collections.abc import Container
from typing import Any

from pydantic import BaseModel

from nrp_core.brain.backends import brains
from nrp_core.errors import BackendError
from nrp_core.experiment.model.experiment import BrainSection, Experiment, WorldSection
from nrp_core.experiment.reading.reader import EXTENDS
from nrp_core.registry import Registry
from nrp_core.world.backends import worlds

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def experiment_schema() -> dict[str, Any]:
    """Return the JSON Schema, with the options of every installed backend that loads.

    A file that extends another may omit what the other has, so keys below the top level are not required,
    and ``null`` is allowed, which removes a key.
    """
    schema = {"$schema": DIALECT, **Experiment.model_json_schema()}
    extends = {
        "type": ["string", "array"],
        "items": {"type": "string"},
        "description": "The experiments that this one extends: a file or name, or a list of these.",
    }
    schema["properties"] = {EXTENDS: extends, **schema["properties"]}
    required = schema["required"]
    definitions = schema["$defs"]
    for section in (schema, *definitions.values()):
        _allow_removal(section, section.pop("required", ()))
    schema["anyOf"] = [{"required": [EXTENDS]}, {"required": required}]
    for model, registry in ((BrainSection, brains()), (WorldSection, worlds())):
        _add_backends(model, registry, definitions)
    return schema


def _allow_removal(section: dict[str, Any], required: Container[str]) -> None:
    """Allow ``null`` for every key that can be missing, and for every name below one."""
    for key, value in section.get("properties", {}).items():
        if key not in required:
            _allow_null(value)
        for pattern, named in value.get("patternProperties", {}).items():
            value["patternProperties"][pattern] = {"anyOf": [named, {"type": "null"}]}


def _allow_null(value: dict[str, Any]) -> None:
    if "type" in value:
        types = value["type"] if isinstance(value["type"], list) else [value["type"]]
        value["type"] = [*types, "null"]
    if "enum" in value:
        value["enum"] = [*value["enum"], None]
    if "anyOf" in value:
        value["anyOf"] = [*value["anyOf"], {"type": "null"}]


def _add_backends(model: type[BaseModel], registry: Registry[Any], definitions: dict[str, Any]) -> None:
    """Describe the options of each backend if it is selected."""
    section = definitions[model.__name__]
    choices = section["properties"]["backend"]
    choices["anyOf"] = [{"enum": registry.names()}, {"type": choices.pop("type")}]
    section["allOf"] = []
    for name in registry.names():
        try:
            options = registry.load(name).options
        except BackendError:
            continue
        prefix = f"{model.__name__}.{name}."
        described = options.model_json_schema(ref_template=f"#/$defs/{prefix}{{model}}")
        definitions |= {prefix + key: value for key, value in described.pop("$defs", {}).items()}
        chosen = {"properties": {"backend": {"const": name}}, "required": ["backend"]}
        section["allOf"].append({"if": chosen, "then": {"properties": {"options": described}}})
