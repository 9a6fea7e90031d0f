"""``<experimental:params>``: changes that an ``<include>`` makes to the model that it includes.

They are those of http://sdformat.org/tutorials?tut=param_passing_proposal: an element with an ``element_id``
is added to the one that this names, or it is modified, removed or replaced as a whole, or each of its
children says what becomes of the child of that name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from nrp_core.errors import did_you_mean
from nrp_core.world.scene.reading.xml import Element

PARAMS: Final = "experimental:params"
_ID, _ACTION = "element_id", "action"


def change_included(included: Element, include: Element) -> None:
    """Change the first model in a file as the ``<include>`` of it says.

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
    """Put another element in the place of one; it keeps the name if it has none of its own."""
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
    """Return an element below the model and the one that holds it, by the names on the way."""
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
