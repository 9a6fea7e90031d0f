"""The look of SDF's visuals: colours and finishes."""

from __future__ import annotations

from dataclasses import replace

from nrp_core.errors import SceneError
from nrp_core.findings import Code
from nrp_core.world.scene.bodies import TINTS, Look
from nrp_core.world.scene.materials import color_of, glows
from nrp_core.world.scene.model import Rgba
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.material_scripts import Material, image_material, script_material
from nrp_core.world.scene.reading.textures import texture_of
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.finish import albedo_map, read_finish, read_share


def read_look(visual: Element, reading: Reading) -> Look:
    """Return the look of a ``<visual>``: the emissive colour, else the diffuse one."""
    material = visual.find("material")
    opacity = 1 - read_share(visual, "transparency", 0.0, reading)
    if material is None:
        return Look(None, opacity)
    look = _surface(material, reading)
    specular = read_color(material, "specular", reading)
    finish = read_finish(material, specular, reading)
    return replace(look, opacity=opacity, finish=finish, tints=TINTS in material.attributes)


def _surface(material: Element, reading: Reading) -> Look:
    """Return the colour of a material, whether it glows, and its image."""
    emissive, diffuse, ambient = (
        read_color(material, tag, reading) for tag in ("emissive", "diffuse", "ambient")
    )
    if emissive and any(emissive[:3]):
        return Look(emissive, glows=True)
    albedo = albedo_map(material, reading)
    if albedo:
        (red, green, blue), (r, g, b, alpha) = albedo.mean, diffuse or (1.0, 1.0, 1.0, 1.0)
        return Look((r * red, g * green, b * blue, alpha), texture=texture_of(albedo.path, (r, g, b)))
    if diffuse:
        return Look(diffuse)
    found = _script(material, reading)
    if found is None:
        return Look(ambient)
    return Look(found.rgba, glows=found.glows, texture=texture_of(found.image))


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
            color, Code.NRP264, f"<{tag}> holds numbers from 0 to 1, not '{color.text}': read as 255ths"
        )
        parts = tuple(min(max(part / 255 if part > 1 else part, 0.0), 1.0) for part in parts)
    r, g, b, *alpha = parts
    return r, g, b, alpha[0] if alpha else 1.0


def _script(material: Element, reading: Reading) -> Material | None:
    script = material.section("script")
    name = script.find("name") or script  # as old files write it
    if not name.text:
        if material.find("script"):
            reading.notes.warn(script, Code.NRP259, "the <script> has no <name>: shown grey")
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
        reading.notes.warn(name, Code.NRP259, f"shown grey: {error}", subject=name.text)
        return None
