"""The imports of generated code: the packages of the types and functions that it names."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_bibi.generation.expressions import in_framework
from nrp_bibi.generation.walk import channels, parts
from nrp_bibi.model.channels import TopicChannel
from nrp_bibi.model.expressions import Call
from nrp_bibi.model.functions import Bibi, BIBITransferFunction
from nrp_bibi.model.metamodel import Node

FRAMEWORK = "import hbp_nrp_client.tf_framework as nrp"


def imports(model: Bibi) -> dict[str, int]:
    """Return the import statements, the framework first, and the line of an element that needs each."""
    functions = [one for one in model.transfer_function if isinstance(one, BIBITransferFunction)]
    needed: dict[str, int] = {}
    for module, line in (found for function in functions for found in _modules(function)):
        needed.setdefault(f"import {module}", line)
    return {FRAMEWORK: 1, **dict(sorted(needed.items()))}


def _modules(function: BIBITransferFunction) -> Iterator[tuple[str, int]]:
    own = {part.name for part in (*function.local, *channels(function))}
    for part in parts(function):
        module, _, name = _type_named(part).rpartition(".")
        root = module.partition(".")[0]
        if name and root not in ("", "nrp", *own):
            yield module, part.line


def _type_named(part: Node) -> str:
    return in_framework(part.type) if isinstance(part, (Call, TopicChannel)) else ""
