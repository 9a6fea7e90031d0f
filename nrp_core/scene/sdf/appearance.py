"""The look of SDF's visuals and lights: colours, finishes, textures and material scripts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from math import inf, pi, sqrt
from pathlib import Path

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.findings import Code
from nrp_core.scene.bodies import TINTS, Appearance
from nrp_core.scene.materials import color_of, glows
from nrp_core.scene.meshes import MAX_BYTES_BESIDE
from nrp_core.scene.meshes.stl import mean_color
from nrp_core.scene.model import PLASTIC, Finish, Light, Rgba
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.geometry import texture_of
from nrp_core.scene.rigid import Pose, Vector

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
    shininess = material.number("shininess", 0.0)
    if metal is not None:
        return Finish(_share(metal, "roughness", 0.5, reading), _share(metal, "metalness", 0.5, reading))
    if gloss is not None:
        found = read_map(gloss, "specular_map", reading)
        reflectance = (found.mean if found else bright) or PLASTIC
        return Finish(1 - _share(gloss, "glossiness", 0.0, reading), 0.0, reflectance)
    if bright is not None:
        r, g, b = (_BURLEY * part for part in bright)
        return Finish(_roughness(shininess), 0.0, (r, g, b))
    return None


@dataclass(frozen=True, slots=True)
class Map:
    """The image of a map and its mean colour, 0..1."""

    path: Path
    mean: tuple[float, float, float]


def read_map(workflow: Element, tag: str, reading: Reading) -> Map | None:
    """Return a map, or None; warn if it cannot be read."""
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
    reading.notes.warn(uri, Code.NRP258, f"the image '{uri.text}' {reason}: left out", subject=uri.text)
    return None


def _share(workflow: Element, tag: str, default: float, reading: Reading) -> float:
    """Return a share from 0 to 1: the mean of its map, else its number."""
    found = read_map(workflow, f"{tag}_map", reading)
    if found is not None:
        workflow.pass_over(tag)
        return sum(found.mean) / 3
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


MAX_BYTES = 10_000_000
"""Maximum size of a script, bytes; five times as much for an image."""

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_HEAD = re.compile(r"^\s*material\s+(\S+)", re.MULTILINE)
_PROPERTY = re.compile(r"^\s*(ambient|diffuse|emissive|texture)\s+(.+?)\s*$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Material:
    """The colour of a material, whether it glows, and the image whose mean it is."""

    rgba: Rgba
    glows: bool = False
    image: Path | None = None


def script_material(name: str, places: Iterable[Path], textures: Iterable[Path] = ()) -> Material | None:
    """Return a material; None if no script has it or it has no colour.

    Args:
        name: its name in the script.
        places: scripts, or folders of scripts and images.
        textures: folders to search last for images.
    """
    places = list(places)
    folders = [place if place.is_dir() else place.parent for place in places]
    for script in _scripts(places):
        text = _COMMENT.sub("", _contents(script, MAX_BYTES).decode(errors="replace"))
        heads = list(_HEAD.finditer(text))
        ends = [*(head.start() for head in heads), len(text)][1:]
        for head, end in zip(heads, ends, strict=False):  # a missing brace counts as the end
            if head[1] == name:
                return _material(
                    text[head.end() : end], [*folders, script.parent.parent / "textures", *textures]
                )
    return None


def image_material(name: str, folders: Iterable[Path]) -> Material | None:
    """Return the material of the image with a name; None if it is in none of the folders."""
    image = next((path for folder in folders if (path := folder / name).is_file()), None)
    mean = mean_color(_contents(image, 5 * MAX_BYTES)) if image else None
    return Material((*mean, 1.0), image=image) if mean else None


def _scripts(places: Iterable[Path]) -> Iterator[Path]:
    for place in places:
        if place.is_dir():
            yield from sorted(place.glob("*.material"))
        elif place.suffix == ".material":
            yield place


def _material(body: str, folders: Iterable[Path]) -> Material | None:
    found: dict[str, str] = {}
    for match in _PROPERTY.finditer(body):
        found.setdefault(match[1], match[2])
    emissive = _numbers(found.get("emissive", ""))
    if emissive and any(emissive[:3]):
        return Material(emissive, glows=True)
    textured = image_material(found["texture"].split()[0], folders) if "texture" in found else None
    lit = _numbers(found.get("diffuse", "")) or _numbers(found.get("ambient", ""))
    return textured or (Material(lit) if lit else None)


def _numbers(text: str) -> Rgba | None:
    """Return three or four numbers as a colour; a fifth one is another property's."""
    with suppress(ValueError):
        r, g, b, *alpha = (min(max(float(word), 0.0), 1.0) for word in text.split()[:4])
        return r, g, b, alpha[0] if alpha else 1.0
    return None


def _contents(path: Path, limit: int) -> bytes:
    with suppress(OSError):
        if path.stat().st_size <= limit:
            return path.read_bytes()
    return b""


def read_appearance(visual: Element, reading: Reading) -> Appearance:
    """Return the appearance of a ``<visual>``: the emissive colour, else the diffuse one."""
    material = visual.find("material")
    opacity = 1 - read_share(visual, "transparency", 0.0, reading)
    if material is None:
        return Appearance(None, opacity)
    look = _surface(material, reading)
    material.pass_over("script")  # not needed beside a colour
    specular = read_color(material, "specular", reading)
    finish = read_finish(material, specular, reading)
    return replace(look, opacity=opacity, finish=finish, tints=TINTS in material.attributes)


def _surface(material: Element, reading: Reading) -> Appearance:
    """Return the colour of a material, whether it glows, and its image."""
    emissive, diffuse, ambient = (
        read_color(material, tag, reading) for tag in ("emissive", "diffuse", "ambient")
    )
    if emissive and any(emissive[:3]):
        return Appearance(emissive, glows=True)
    pbr = material.section("pbr")
    albedo = read_map(pbr.find("metal") or pbr.section("specular"), "albedo_map", reading)
    if albedo:
        (red, green, blue), (r, g, b, alpha) = albedo.mean, diffuse or (1.0, 1.0, 1.0, 1.0)
        return Appearance((r * red, g * green, b * blue, alpha), texture=texture_of(albedo.path, (r, g, b)))
    if diffuse:
        return Appearance(diffuse)
    found = _script(material, reading)
    if found is None:
        return Appearance(ambient)
    return Appearance(found.rgba, glows=found.glows, texture=texture_of(found.image))


def read_color(element: Element, tag: str, reading: Reading) -> Rgba | None:
    """Return the colour in a child: three or four numbers 0..1; None if it is missing.

    As in Gazebo, numbers above 1 are taken as 255ths.
    """
    color = element.find(tag)
    if color is None:
        return None
    parts = color.numbers(3 if len(color.text.split()) == 3 else 4)
    if not all(0 <= part <= 1 for part in parts):
        reading.notes.warn(
            color, Code.NRP384, f"<{tag}> holds numbers from 0 to 1, not '{color.text}': read as 255ths"
        )
        parts = tuple(min(max(part / 255 if part > 1 else part, 0.0), 1.0) for part in parts)
    r, g, b, *alpha = parts
    return r, g, b, alpha[0] if alpha else 1.0


def _script(material: Element, reading: Reading) -> Material | None:
    script = material.section("script")
    name = script.find("name") or script  # as old files write it
    if not name.text:
        if material.find("script"):
            reading.notes.warn(script, Code.NRP258, "the <script> has no <name>: shown grey")
        return None
    places, media = [reading.resources.locate(uri) for uri in script.all("uri")], reading.resources.media()
    found = script_material(name.text, [place for place in places if place], media)
    if found is not None:
        return found
    try:
        return Material(color_of(name.text), glows(name.text))
    except SceneError as error:
        found = script_material(name.text, media) or image_material(name.text, media)
        if found is not None:
            return found
        reading.notes.warn(name, Code.NRP258, f"shown grey: {error}", subject=name.text)
        return None


_KINDS = ("directional", "point", "spot")
_DOWN: Vector = (0.0, 0.0, -1.0)
_WHITE = (1.0, 1.0, 1.0, 1.0)


def read_light(element: Element, name: str, pose: Pose, reading: Reading) -> Light:
    """Return a ``<light>`` at a pose in the world.

    By default, directional lights cast shadows (as Gazebo's sun) and others do not.
    """
    kind = element.attributes.get("type", "point")
    if kind != "spot":
        element.pass_over("spot")
    if kind not in _KINDS:
        raise element.error(f"unknown light type '{kind}'{did_you_mean(kind, _KINDS)}")
    red, green, blue, alpha = read_color(element, "diffuse", reading) or _WHITE
    attenuation = _attenuation(element.find("attenuation"))
    if kind != "directional" and not sum(attenuation[1:]) > 0:
        message = (
            f"the factors of the <attenuation> of the light '{name}' are 0, so it is infinitely bright; "
            "1, 0 and 0 do not weaken it"
        )
        reading.notes.warn(element, Code.NRP264, message, subject=name)
    strength = element.number("intensity", 1.0) if element.flag("light_on", True) else 0.0
    if strength < 0:
        raise element.require("intensity").error(f"the <intensity> of a light must not be {strength:g}")
    return Light(
        name,
        kind,
        pose,
        pose.rotate(element.direction("direction", _DOWN)),
        (strength * red, strength * green, strength * blue, alpha),
        element.flag("cast_shadows", kind == "directional"),
        attenuation,
        _cone(element.find("spot") if kind == "spot" else None, reading),
    )


def _attenuation(element: Element | None) -> tuple[float, float, float, float]:
    """Return range and factors, by default SDF's."""
    if element is None:
        return inf, 1.0, 0.0, 0.0
    constant, linear, quadratic = (
        element.number(tag, default)
        for tag, default in (("constant", 1.0), ("linear", 1.0), ("quadratic", 0.0))
    )
    return element.positive("range", 10.0), constant, linear, quadratic


def _cone(element: Element | None, reading: Reading) -> tuple[float, float]:
    if element is None:
        return pi / 4, pi / 2
    outer = element.positive("outer_angle", pi / 2)
    if outer > 2 * pi:
        message = f"the <outer_angle> of a spot is {outer:g} rad, more than a turn; is it meant in degrees?"
        reading.notes.warn(element, Code.NRP264, message)
    outer = min(outer, 0.99 * pi)
    inner = element.number("inner_angle", outer / 2)
    if inner > outer:
        message = f"the <inner_angle> of a spot, {inner:g} rad, is above its <outer_angle>, which is used"
        reading.notes.warn(element, Code.NRP264, message)
    return min(inner, outer), outer
