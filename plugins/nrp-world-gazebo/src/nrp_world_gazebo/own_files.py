"""The user's own SDF files, which Gazebo reads itself: with plugins, sensors, materials and all.

Only what the experiment decides is changed: the name and the pose, which the world gives; the files that the
model refers to, which get their full names; and the friction of wheels that a planar drive spins.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from copy import deepcopy
from pathlib import Path

from lxml import etree

from nrp_core.errors import SceneError
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.reading.context import Resources
from nrp_core.world import Element, Model
from nrp_world_gazebo.elements import Xml, element, numbers

NEWEST = (1, 7)
"""The newest version of SDF that Gazebo 11 reads."""
_KINDS = {"revolute", "prismatic", "fixed"}
_FILES = {"mesh", "script", "heightmap", "texture", "image"}
"""Elements whose ``<uri>`` is a file."""


class NotOwnError(Exception):
    """A model's file cannot be passed to Gazebo unchanged; the message is a clause with the reason."""


def own_sdf(model: Model, bodies: Sequence[Body]) -> Xml:
    """Return the ``<sdf>`` of a model as its file has it.

    Args:
        model: the model.
        bodies: its bodies, with the friction that they are simulated with.

    Raises:
        NotOwnError: it has no file that Gazebo reads as nrp-core does.
    """
    if model.source is None:
        raise NotOwnError("it was made in Python")
    if model.source.without:
        raise NotOwnError("invalid elements of its file are left out")
    file = model.source.file
    root = _root(file)
    found = [each for each in root.iter("model") if each.get("name") == model.source.element]
    if len(found) != 1:
        raise NotOwnError(f"{file.name} has {len(found)} models '{model.source.element}'")
    own = deepcopy(found[0])
    _require_same(own, model)
    for uri in _uris(own):
        uri.text = f"file://{_full(uri.text or '', file)}"
    _set_friction(own, bodies)
    return element("sdf", own, version=root.get("version", "1.4"))


def _root(file: Path) -> Xml:
    try:
        root = etree.parse(str(file), etree.XMLParser(remove_comments=True, resolve_entities=False)).getroot()
    except (OSError, etree.XMLSyntaxError) as error:
        raise NotOwnError(f"{file.name} is not read again: {error}") from None
    if root.tag not in ("sdf", "gazebo"):
        raise NotOwnError(f"{file.name} is not SDF")
    version = root.get("version", "1.4")
    if tuple(map(int, version.split(".")[:2])) > NEWEST:
        raise NotOwnError(f"{file.name} is SDF {version}, and Gazebo 11 reads up to 1.7")
    return root


def _require_same(own: Xml, model: Model) -> None:
    """Refuse a model whose links and joints have other names in Gazebo than in the scene."""
    if own.find("model") is not None or own.find("include") is not None:
        raise NotOwnError("it contains other models")
    links = {each.get("name") for each in own.findall("link")}
    if links != {link.name for link in model.links}:
        raise NotOwnError("its links were changed when it was read")
    kinds = {each.get("name"): each.get("type") for each in own.findall("joint")}
    for joint in model.joints:
        if kinds.get(joint.name) not in _KINDS:
            raise NotOwnError(
                f"its joint '{joint.name}' is of a kind that Gazebo and nrp-core count differently"
            )


def _uris(own: Xml) -> Iterator[Xml]:
    for uri in own.iter("uri"):
        parent = uri.getparent()
        if parent is not None and parent.tag in _FILES:
            yield uri


def _full(uri: str, file: Path) -> Path:
    wanted = Element("uri", {}, file, 0, text=uri.strip())
    try:
        found = Resources().locate(wanted)
    except SceneError:
        found = None
    if found is None:
        raise NotOwnError(f"there is no '{uri.strip()}'")
    return found.absolute()


def _set_friction(own: Xml, bodies: Iterable[Body]) -> None:
    """Take the friction of the wheels of planar drives away, which roll without it in every world."""
    for body in bodies:
        slides = [each for link in body.links for each in link.collisions if each.friction == 0.0]
        if not slides:
            continue
        names = {link.name for link in body.links}
        for link in own.findall("link"):
            for collision in link.findall("collision") if link.get("name") in names else ():
                for surface in collision.findall("surface"):
                    collision.remove(surface)
                friction = element("ode", numbers("mu", 0), numbers("mu2", 0))
                collision.append(element("surface", element("friction", friction)))
        for joint in own.findall("joint"):
            for dynamics in joint.findall("axis/dynamics") if _moves(joint, body) else ():
                dynamics.getparent().remove(dynamics)


def _moves(joint: Xml, body: Body) -> bool:
    return body.joint is not None and joint.get("name") == body.joint.name


def folders_of(sdf: Xml) -> set[Path]:
    """Return the folders with the files that an own model refers to."""
    return {_folder(Path((uri.text or "").removeprefix("file://"))) for uri in _uris(sdf)}


def _folder(path: Path) -> Path:
    return path if path.is_dir() else path.parent
