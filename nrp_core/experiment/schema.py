"""The experiment file as a JSON Schema, for editors: completion, help and checks while writing."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from nrp_core.errors import BackendError
from nrp_core.experiment.model import BrainSection, Experiment, WorldSection
from nrp_core.experiment.reader import EXTENDS
from nrp_core.registry import Registry, brains, worlds

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def experiment_schema() -> dict[str, Any]:
    """Return the JSON Schema, with the options of every installed backend that loads.

    A file that extends another may leave out what that one has, so below the top nothing is required,
    and ``null`` may stand where a name is to be removed.
    """
    schema = {"$schema": DIALECT, **Experiment.model_json_schema()}
    extends = {
        "type": ["string", "array"],
        "items": {"type": "string"},
        "description": "What this experiment is laid over: files or names, one or a list.",
    }
    schema["properties"] = {EXTENDS: extends, **schema["properties"]}
    schema["anyOf"] = [{"required": [EXTENDS]}, {"required": schema.pop("required")}]
    definitions = schema["$defs"]
    for section in definitions.values():
        section.pop("required", None)
        _allow_removal(section)
    _allow_removal(schema)
    for model, registry in ((BrainSection, brains()), (WorldSection, worlds())):
        _add_backends(model, registry, definitions)
    return schema


def _allow_removal(section: dict[str, Any]) -> None:
    for value in section.get("properties", {}).values():
        for pattern, named in value.get("patternProperties", {}).items():
            value["patternProperties"][pattern] = {"anyOf": [named, {"type": "null"}]}


def _add_backends(model: type[BaseModel], registry: Registry[Any], definitions: dict[str, Any]) -> None:
    """Describe the options of each backend where it is the one that is chosen."""
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
