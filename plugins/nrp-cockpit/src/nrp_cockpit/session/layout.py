"""The layout of the page, in a file beside the experiment or the recording."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Any, Final

from nrp_cockpit.wire.channels import Channel, Channels
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.world.messages.cdr import Codec

SUFFIX: Final = ".cockpit.json"
"""The suffix of a layout's file."""
PANELS: Final = ("scene", "camera", "map", "brain", "spikes", "traces", "inspector")
"""The panels of the page, as in ``page/src/layout/tree.ts``."""
_VERSION: Final = 1
_TEXTS: Final = ("string", "wstring")
_STEP: Final = re.compile(r"([^.\[\]]+)(\[\d+\])?")


class Layout:
    """The layout of the page: where its panels are, and the curves of its plots.

    Args:
        path: its file; None: it cannot be saved.
        channels: the channels that the page can plot.
    """

    def __init__(self, path: Path | None, channels: Channels) -> None:
        self._path, self._channels = path, channels

    def load(self) -> dict[str, Any]:
        """Return the ``layout``, if there is one that the page can use, and its ``problem``, if it has one.

        Curves of unknown topics or fields are a problem and stay: a later change of the run may offer them.
        """
        if self._path is None or not self._path.exists():
            return {}
        text = ""
        try:
            text = self._path.read_text(encoding="utf-8")
            layout = json.loads(text)
            _require(layout)
        except (OSError, ValueError, RecursionError) as error:
            return {"problem": self._problem(error, text, "; the page has its usual layout")}
        flaws = [flaw for trace in layout["traces"] for flaw in self._flaws(trace)]
        if not flaws:
            return {"layout": layout}
        return {"layout": layout, "problem": self._problem(flaws[0], text)}

    def save(self, layout: dict[str, Any]) -> None:
        """Write the layout.

        Raises:
            ExperimentError: it is none, or the folder cannot be written.
        """
        try:
            _require(layout)
        except _WrongError as error:
            raise ExperimentError(f"this is not a layout of the page: {error}") from None
        if self._path is None:
            return
        try:
            self._path.write_text(json.dumps(layout, indent=2) + "\n", encoding="utf-8")
        except OSError as error:
            raise ExperimentError(f"the layout cannot be saved: {error.strerror}", path=self._path) from error

    def _problem(self, error: Exception, text: str, then: str = "") -> str:
        """Return a sentence with the file, and with the line if it is known."""
        line = None
        match error:
            case _WrongError():
                said = str(error)
                lines = enumerate(text.splitlines(), 1)
                line = next((n for n, one in lines if json.dumps(error.value) in one), None)
            case json.JSONDecodeError():
                said, line = f"not JSON: {error.msg}", error.lineno
            case OSError():
                said = f"cannot be read: {error.strerror}"
            case _:
                said = f"not JSON: {error}"
        return str(ExperimentError(f"the layout: {said}{then}", path=self._path, line=line))

    def _flaws(self, trace: dict[str, str]) -> Iterator[_WrongError]:
        """Yield what a curve asks for that the run does not offer."""
        topic, path = trace["topic"], trace["path"]
        if topic not in self._channels:
            known = [channel.topic for channel in self._channels if channel.encoding == "cdr"]
            message = f"nothing is offered on the topic '{topic}' of a curve{did_you_mean(topic, known)}"
            yield _WrongError(message, topic)
        elif hint := _missing_field(self._channels[topic], path):
            yield _WrongError(f"messages on {topic} have no number '{path}' for a curve{hint}", path)


class _WrongError(ValueError):
    """A part of a layout that is wrong: why, and its value in the file."""

    def __init__(self, message: str, value: Any) -> None:
        super().__init__(message)
        self.value = value


def _require(layout: Any) -> None:
    """Refuse what is not a layout.

    Raises:
        _WrongError: it is none.
    """
    given = _object(layout, ("version", "tree", "traces"), "it")
    if given["version"] != _VERSION:
        message = f"its 'version' is {given['version']!r}, and this page reads {_VERSION}"
        raise _WrongError(message, given["version"])
    panels = list(_panels(given["tree"], "tree"))
    for panel in PANELS:
        if panels.count(panel) != 1:
            said = "twice" if panel in panels else "not"
            raise _WrongError(f"the panel '{panel}' is {said} in 'tree'", panel)
    if not isinstance(given["traces"], list):
        raise _WrongError("'traces' is not a list", given["traces"])
    for i, trace in enumerate(given["traces"]):
        curve = _object(trace, ("topic", "path"), f"traces[{i}]")
        for name, value in curve.items():
            if not isinstance(value, str):
                raise _WrongError(f"'{name}' of traces[{i}] is {value!r}, not a text", value)


def _panels(node: Any, where: str) -> Iterator[str]:
    """Yield the panels of a part of the tree."""
    if isinstance(node, str):
        if node not in PANELS:
            raise _WrongError(f"there is no panel '{node}'{did_you_mean(node, PANELS)}", node)
        yield node
        return
    given = _object(node, ("direction", "parts", "sizes"), where)
    direction, parts, sizes = given["direction"], given["parts"], given["sizes"]
    if direction not in ("row", "column"):
        raise _WrongError(f"'direction' of {where} is {direction!r}, not 'row' or 'column'", direction)
    if not isinstance(parts, list) or not isinstance(sizes, list) or len(parts) != len(sizes):
        raise _WrongError(f"{where} needs two lists of one length, 'parts' and 'sizes'", direction)
    for size in sizes:
        if not isinstance(size, int | float) or not isfinite(size) or size <= 0:
            raise _WrongError(f"a size of {where} is {size!r}, not a number above 0", size)
    for i, part in enumerate(parts):
        yield from _panels(part, f"{where}.parts[{i}]")


def _object(value: Any, names: tuple[str, ...], where: str) -> dict[str, Any]:
    """Return an object that has these names and no others."""
    if not isinstance(value, dict):
        raise _WrongError(f"{where} is not a JSON object", value)
    for name in value:
        if name not in names:
            raise _WrongError(f"{where} has an unknown key '{name}'{did_you_mean(name, names)}", name)
    for name in names:
        if name not in value:
            raise _WrongError(f"{where} has no '{name}'", None)
    return value


def _missing_field(channel: Channel, path: str) -> str:
    """Return a hint if messages of a channel have no number at this path; empty if they have one."""
    if channel.encoding != "cdr":
        return "; its messages are not plotted"
    codec, kind = Codec({channel.schema_name: channel.schema}), channel.schema_name
    for name, index in _STEP.findall(path):
        fields = {field.name: field for field in codec.fields(kind)} if "/" in kind else {}
        if name not in fields:
            return did_you_mean(name, fields)
        found, kind = fields[name], fields[name].type
        if bool(index) != (found.many or found.length is not None):
            return f"; '{name}' is {'one value' if index else f'a list: {name}[0] is its first item'}"
    if "/" in kind:
        return "; a curve needs one of " + ", ".join(field.name for field in codec.fields(kind))
    return "; it is a text" if kind in _TEXTS else ""
