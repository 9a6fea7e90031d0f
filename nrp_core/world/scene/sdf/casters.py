"""Ball casters: joints of type ``ball`` are fixed here, so a ball that would roll in one slides."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from nrp_core.world.scene.model import Link, Sphere
from nrp_core.world.scene.xml_tree import Element


def with_sliding_balls(links: Iterable[Link], model: Element) -> Iterator[Link]:
    """Yield the links of a model, those without friction that are balls in a ``ball`` joint."""
    held = {j.require("child").text for j in model.all("joint") if j.attributes.get("type") == "ball"}
    for link in links:
        if link.name in held and all(isinstance(each.geometry, Sphere) for each in link.collisions):
            slippery = tuple(replace(collision, friction=0.0) for collision in link.collisions)
            link = replace(link, collisions=slippery)
        yield link
