"""Open and check files of SDF or URDF, and the files that they include."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

from nrp_core.archives import unpack
from nrp_core.errors import SceneError, did_you_mean
from nrp_core.findings import Code
from nrp_core.scene.reading.context import (
    Element,
    Reading,
    leave_out,
    main_file,
    read_added,
    read_xml,
)

PARAMS: Final = "experimental:params"
_ID, _ACTION = "element_id", "action"


def change_included(included: Element, include: Element) -> None:
    """Apply the changes in an ``<include>`` to the first model in a file.

    Args:
        included: the root of the file, or its world.
        include: the ``<include>``.

    Raises:
        SceneError: a change has no place, or is none.
    """
    for params in include.all(PARAMS):
        model = included.find("model")
        if model is None:
            raise params.error(f"<{PARAMS}> changes a model, and the included file has none")
        for change in params.children:
            _apply(change, model)


def _apply(change: Element, model: Element) -> None:
    named = change.attributes.get(_ID)
    if named is None:
        raise change.error(f'<{change.tag}> in <{PARAMS}> needs an attribute {_ID}="..."')
    action = change.attributes.get(_ACTION)
    if action is None:
        _, found = _by_id(named, change, model)
        for child in change.children:
            parts = child.attributes.get(_ACTION)
            if parts is None:
                raise child.error(f'<{child.tag}> needs an action="...", since <{change.tag}> has none')
            _act(parts, child, found)
    elif action == "add":
        change.attribute("name")
        holder = _by_id(named, change, model, any_tag=True)[1] if named else model
        _act(action, change, holder)
    else:
        holder, found = _by_id(named, change, model)
        _ACTIONS[_valid(action, change)](change, found, holder)


def _act(action: str, change: Element, holder: Element) -> None:
    """Apply a change to the child of an element with its tag and name."""
    found = _child(change, holder)
    if _valid(action, change) == "add":
        if found is not None and "name" in change.attributes:
            name = change.attributes["name"]
            raise change.error(f"the included model has a <{change.tag}> '{name}' there already")
        holder.children.append(_copy(change))
        return
    if found is None:
        raise change.error(f"the included model has no <{change.tag}> to {action} in its <{holder.tag}>")
    _ACTIONS[action](change, found, holder)


def _valid(action: str, change: Element) -> str:
    if action != "add" and action not in _ACTIONS:
        hint = did_you_mean(action, ("add", *_ACTIONS))
        raise change.error(f"<{change.tag}> has no action '{action}'{hint}")
    return action


def _modify(change: Element, found: Element, _: Element) -> None:
    """Give an element, and those in it, other values."""
    found.attributes.update(
        {key: value for key, value in change.attributes.items() if key not in (_ID, _ACTION)}
    )
    if change.text:
        found.text, found.raw_text, found.path, found.line = (
            change.text, change.raw_text, change.path, change.line,
        )  # fmt: skip
    for child in change.children:
        inner = _child(child, found)
        if inner is None:
            raise child.error(f"the included model has no <{child.tag}> to modify in its <{found.tag}>")
        _modify(child, inner, found)


def _remove(change: Element, found: Element, holder: Element) -> None:
    """Remove an element, or only those in it that the change names."""
    if not change.children:
        holder.children.remove(found)
    for child in change.children:
        inner = _child(child, found)
        if inner is None:
            raise child.error(f"the included model has no <{child.tag}> to remove in its <{found.tag}>")
        found.children.remove(inner)


def _replace(change: Element, found: Element, holder: Element) -> None:
    """Replace an element by another, which takes over its name if it has none."""
    new = _copy(change)
    if "name" in found.attributes:
        new.attributes.setdefault("name", found.attributes["name"])
    holder.children[holder.children.index(found)] = new


_ACTIONS: Final[dict[str, Callable[[Element, Element, Element], None]]] = {
    "modify": _modify, "remove": _remove, "replace": _replace,
}  # fmt: skip


def _copy(change: Element) -> Element:
    attributes = {key: value for key, value in change.attributes.items() if key not in (_ID, _ACTION)}
    return replace(change, attributes=attributes, children=list(change.children))


def _child(wanted: Element, holder: Element) -> Element | None:
    """Return the child with a tag, and with the name if one is given."""
    name = wanted.attributes.get("name")
    return next(
        (each for each in holder.all(wanted.tag) if name in (None, each.attributes.get("name"))), None
    )


def _by_id(named: str, change: Element, model: Element, *, any_tag: bool = False) -> tuple[Element, Element]:
    """Return an element below the model and its parent, by the names on the path."""
    ways = [(model, named)]
    while ways:
        holder, rest = ways.pop()
        for child in holder.children:
            name = child.attributes.get("name", "")
            if name == rest and (any_tag or child.tag == change.tag):
                return holder, child
            if name and rest.startswith(f"{name}::"):
                ways.append((child, rest.removeprefix(f"{name}::")))
    what = "element" if any_tag else f"<{change.tag}>"
    raise change.error(f"the included model has no {what} '{named}'")


OLDEST, NEWEST = (1, 4), (1, 12)
_SCOPES_RESERVED = (1, 8)
"""The first version in which no name may contain ``::``."""


@dataclass(frozen=True, slots=True)
class SdfFile:
    """A file.

    Args:
        root: its ``<sdf>``; for URDF the equivalent one.
        version: the version of SDF.
        trail: the chain of including files, this one last.
    """

    root: Element
    version: tuple[int, int]
    trail: tuple[Path, ...]

    @classmethod
    def open(cls, path: Path, reading: Reading, trail: tuple[Path, ...] = ()) -> SdfFile:
        """Read a file, also one in an archive or written in xacro.

        Raises:
            SceneError: it does not exist, is not well-formed, or is neither SDF nor URDF.
        """
        if path.suffix.lower() == ".zip":
            path = _in_archive(path)
        root = read_xml(path)
        leave_out(root, reading.without)
        written = root.tag in ("sdf", "gazebo")
        expanded = _expanded(root, path, reading) if root.tag == "robot" else None
        if reading.args and not trail and expanded is None:
            raise root.error("this is not a xacro file, so it has no arguments")
        root = expanded or root
        reading.written.append(root)
        if root.tag == "robot":
            from nrp_core.scene.urdf import to_sdf  # many scenes have no URDF

            root = to_sdf(root, reading.notes)
        if root.tag not in ("sdf", "gazebo"):
            root = read_added(root, reading.notes) or root
        if root.tag not in ("sdf", "gazebo"):
            raise root.error(f"this is neither SDF nor URDF: its root is <{root.tag}>")
        if root.tag == "gazebo":
            root = root.find("sdf") or root  # which it may contain, or be by its old name
            root.attributes.setdefault("version", "1.4")
        reading.opened.append(root)
        version = _version(root, reading)
        if written and version >= _SCOPES_RESERVED:
            _check_names(root)
        return cls(root, version, (*trail, path.resolve()))

    def include(self, include: Element, reading: Reading) -> SdfFile | None:
        """Open the file that an ``<include>`` refers to; None if it is missing and the reading is lenient.

        Raises:
            SceneError: it is missing, cannot take the include's changes, or includes form a cycle.
        """
        uri = include.require("uri")
        if reading.lenient and uri.text and reading.resources.locate(uri) is None:
            reading.notes.warn(include, Code.NRP260, f"there is no '{uri.text}': left out", subject=uri.text)
            include.passed_over = True
            return None
        path = reading.resources.model_file(uri)
        if path.resolve() in self.trail:
            circle = " -> ".join(file.name for file in (*self.trail, path))
            raise include.error(f"files include each other in a cycle: {circle}")
        source = SdfFile.open(path, reading, self.trail)
        change_included(source.root.find("world") or source.root, include)
        return source


_SCOPED = ("world", "model", "frame", "link", "joint", "collision", "visual", "sensor", "light")
"""Elements that scopes name; the names of others, such as plugins, are of another kind."""


def _check_names(element: Element) -> None:
    """Check that no name contains ``::``, which separates a nested model from its parts.

    Raises:
        SceneError: one does.
    """
    for child in element.children:
        if child.tag in _SCOPED and "::" in (name := child.attributes.get("name", "")):
            raise child.error(
                f"the name '{name}' must not contain '::', which separates scopes from SDF 1.8 on"
            )
        if child.tag not in ("state", "plugin"):
            _check_names(child)


def _expanded(root: Element, path: Path, reading: Reading) -> Element | None:
    """Return a file of URDF with its macros expanded; None if it has none."""
    from nrp_core.scene.urdf.expand import drop_unknown_calls, expand_xacro, is_xacro

    for call in drop_unknown_calls(root) if path.suffix == ".urdf" else ():
        message = f"<{call.tag}> is left out: the file has no such macro"
        reading.notes.warn(call, Code.NRP260, message, subject=call.tag)
    if not is_xacro(root):
        return None
    package = partial(reading.resources.package, user=path.absolute())
    warn = partial(reading.notes.warn, replace(root, line=1), Code.NRP260)
    return expand_xacro(path, package, reading.args, warn if reading.lenient else None)


def _in_archive(archive: Path) -> Path:
    """Return the file of the model in an archive."""
    found = main_file(unpack(archive, SceneError))
    if found is None:
        raise SceneError("the archive holds no SDF or URDF file", path=archive)
    return found


def _version(root: Element, reading: Reading) -> tuple[int, int]:
    text = root.attribute("version")
    match = re.fullmatch(r"(\d+)\.(\d+)(\.\d+)?", text)
    if match is None:
        raise root.error(f"an SDF version must be written like '1.9', not '{text}'")
    version = int(match[1]), int(match[2])
    if not OLDEST <= version <= NEWEST:
        reading.notes.warn(
            root, Code.NRP264, f"SDF {text} is not a supported version; supported: 1.4 to 1.12"
        )
    return version
