"""The finishes of SDF's materials: physically based ones, and those of Phong's model.

A map is replaced by its mean, which takes precedence over the number; viewers show the albedo map itself.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from math import sqrt
from pathlib import Path

from nrp_core.findings import Code
from nrp_core.world.scene.finish import PLASTIC, Finish
from nrp_core.world.scene.meshes import MAX_BYTES_BESIDE
from nrp_core.world.scene.meshes.images import mean_color
from nrp_core.world.scene.model import Rgba
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.xml import Element

_BURLEY = 0.08  # reflectance of the brightest specular colour (Burley 2012): an index of 1.8


def read_finish(material: Element, specular: Rgba | None, reading: Reading) -> Finish | None:
    """Return the finish of a ``<material>``, None if it is matt.

    Args:
        material: the element.
        specular: its ``<specular>`` colour, if it has one.
        reading: the context of the reading.
    """
    metal, gloss = material.find("pbr", "metal"), material.find("pbr", "specular")
    bright = specular[:3] if specular and any(specular[:3]) else None
    if metal is not None:
        return Finish(_share(metal, "roughness", 0.5, reading), _share(metal, "metalness", 0.5, reading))
    if gloss is not None:
        reflectance = map_color(gloss, "specular_map", reading) or bright or PLASTIC
        return Finish(1 - _share(gloss, "glossiness", 0.0, reading), 0.0, reflectance)
    if bright is not None:
        r, g, b = (_BURLEY * part for part in bright)
        return Finish(_roughness(material.number("shininess", 0.0)), 0.0, (r, g, b))
    return None


@dataclass(frozen=True, slots=True)
class Map:
    """The image of a map and its mean colour, 0..1."""

    path: Path
    mean: tuple[float, float, float]


def albedo_map(material: Element, reading: Reading) -> Map | None:
    """Return the ``<albedo_map>`` of a material, None if it has none."""
    pbr = material.section("pbr")
    workflow = pbr.find("metal") or pbr.section("specular")
    return read_map(workflow, "albedo_map", reading)


def map_color(workflow: Element, tag: str, reading: Reading) -> tuple[float, float, float] | None:
    """Return the mean colour of a map; None if there is none, with a warning if it cannot be read."""
    found = read_map(workflow, tag, reading)
    return found.mean if found else None


def read_map(workflow: Element, tag: str, reading: Reading) -> Map | None:
    """Return a map; None if there is none, with a warning if it cannot be read."""
    uri = workflow.find(tag)
    if uri is None or not uri.text:
        return None
    mean = None
    path = reading.resources.find(uri)
    with suppress(OSError):
        if path is not None and path.stat().st_size <= MAX_BYTES_BESIDE:
            mean = mean_color(path.read_bytes())
    if path is not None and mean is not None:
        return Map(path, mean)
    reason = "is not there" if path is None else "cannot be read"
    reading.notes.warn(uri, Code.NRP259, f"the image '{uri.text}' {reason}: left out", subject=uri.text)
    return None


def _share(workflow: Element, tag: str, default: float, reading: Reading) -> float:
    """Return a share from 0 to 1: the mean of its map, else its number."""
    mean = map_color(workflow, f"{tag}_map", reading)
    if mean is not None:
        return sum(mean) / 3
    return read_share(workflow, tag, default, reading)


def read_share(element: Element, tag: str, default: float, reading: Reading) -> float:
    """Return a number from 0 to 1; another one is replaced by the nearest of these, with a warning."""
    value = element.number(tag, default)
    share = min(max(value, 0.0), 1.0)
    if share != value:
        where = element.require(tag)
        reading.notes.warn(
            where, Code.NRP264, f"<{tag}> must be from 0 to 1, not {value:g}: {share:g} is used"
        )
    return share


def _roughness(shininess: float) -> float:
    """Return the roughness whose highlight is as wide as that of a Blinn-Phong exponent.

    The width of the distribution of slopes is ``sqrt(2 / (exponent + 2))`` (Walter et al. 2007).
    """
    return sqrt(sqrt(2 / (max(shininess, 0.0) + 2)))
