"""Read XML leniently: by local names, in any order; other content is ignored."""

from __future__ import annotations

import re
from math import isfinite, nan

from nrp_core._support.xml import Element

_DURATION = re.compile(
    r"P(?:(?P<days>\d+)D)?(?:T(?:(?P<hours>\d+)H)?(?:(?P<minutes>\d+)M)?(?:(?P<seconds>\d+(?:\.\d*)?)S)?)?"
)
_SHORTEST, _LONGEST = 1e-6, 1e9  # of the step, in ms: the resolution of time is 1 ns
_SECONDS = {"days": 86_400.0, "hours": 3600.0, "minutes": 60.0, "seconds": 1.0}


def local(name: str) -> str:
    """Return a name without its prefix."""
    return name.rpartition(":")[2]


def children(element: Element, *names: str) -> list[Element]:
    """Return the children of these local names, in their order."""
    return [child for child in element.children if local(child.tag) in names]


def child(element: Element, *names: str) -> Element | None:
    """Return the first child of one of these local names."""
    return next(iter(children(element, *names)), None)


def text(element: Element, *names: str) -> str:
    """Return the text of the first such child, on one line; empty if there is none."""
    found = child(element, *names)
    return " ".join(found.text.split()) if found is not None else ""


def attribute(element: Element, *names: str) -> str | None:
    """Return the first of these attributes that is given, by its local name."""
    given = {local(name): value.strip() for name, value in element.attributes.items()}
    return next((given[name] for name in names if given.get(name)), None)


def number(element: Element, name: str) -> float | None:
    """Return an attribute that is a number, None if it is missing.

    Raises:
        ExperimentError: it is not a number.
    """
    value = attribute(element, name)
    try:
        found = None if value is None else float(value)
    except ValueError:
        found = nan
    if found is not None and not isfinite(found):
        raise element.error(f"'{name}' of <{element.tag}> must be a number, not '{value}'")
    return found


def flag(element: Element, name: str, default: bool) -> bool:
    """Return an attribute that is true or false; other values are ignored."""
    known = {"true": True, "1": True, "false": False, "0": False}
    return known.get((attribute(element, name) or "").lower(), default)


def milliseconds_of(element: Element) -> float:
    """Return the number of milliseconds that an element holds.

    Raises:
        ExperimentError: it is not a positive number.
    """
    try:
        found = float(element.text)
    except ValueError:
        found = nan
    if found and not _SHORTEST <= found <= _LONGEST:
        raise element.error(f"<{element.tag}> must be a number of milliseconds, not '{element.text}'")
    return found


def seconds_of(element: Element) -> float:
    """Return the duration that an element holds: ``840``, ``840.0`` or, as XML Schema writes it, ``PT14M``.

    Raises:
        ExperimentError: it is neither.
    """
    said = element.text
    match = _DURATION.fullmatch(said)
    try:
        if match is not None and any(match.groups()):
            found = sum(float(part) * _SECONDS[unit] for unit, part in match.groupdict().items() if part)
        else:
            found = float(said)
    except ValueError:
        found = nan
    if found and not _SHORTEST <= found <= _LONGEST:
        raise element.error(
            f"<{element.tag}> must be a time in seconds or a duration such as PT14M, not '{said}'"
        )
    return found
