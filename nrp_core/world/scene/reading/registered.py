"""Find the class or function that is registered for a name in a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar

from nrp_core.errors import BackendError, did_you_mean
from nrp_core.registry import Registry
from nrp_core.world.scene.model import Joint, Link
from nrp_core.world.scene.reading.xml import Element

Plugin = TypeVar("Plugin")
Part = TypeVar("Part", Link, Joint)


@dataclass(frozen=True, slots=True)
class ModelParts:
    """The links and joints of the model with a ``<plugin>``."""

    links: Sequence[Link]
    joints: Sequence[Joint]

    def link(self, named: Element) -> Link:
        """Return the link that an element names."""
        return part_named(named, named.text, self.links, "link")

    def joint(self, named: Element, name: str | None = None) -> Joint:
        """Return the joint that an element names, by its text or else by a name."""
        return part_named(named, named.text if name is None else name, self.joints, "joint")


def registered(registry: Registry[Plugin], name: str, element: Element) -> Plugin | None:
    """Return the plugin with a name, imported at its first use; None if there is none.

    Raises:
        SceneError: it does not import, or two distributions provide it.
    """
    if name not in registry.names():
        return None
    try:
        found: Plugin = _load(registry, name)
    except BackendError as error:
        raise element.error(str(error)) from error
    return found


@cache
def _load(registry: Registry[Any], name: str) -> Any:
    return registry.load(name)


def part_named(element: Element, name: str, parts: Sequence[Part], kind: str) -> Part:
    """Return the link or joint with a name; an error at the element if the model does not have it."""
    for part in parts:
        if part.name == name:
            return part
    hint = did_you_mean(name, [part.name for part in parts])
    raise element.error(f"the model has no {kind} '{name}'{hint}")
