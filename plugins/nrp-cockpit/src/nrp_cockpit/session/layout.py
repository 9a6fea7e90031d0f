"""The layout of the page: the user's own one, or the preset beside the experiment or the recording."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from platformdirs import user_config_path

from nrp_cockpit.session.arrangement import Arrangement, Curve
from nrp_cockpit.wire.channels import Channel, Channels
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import form_of, read_form, tree_of
from nrp_core.messages.cdr import Codec
from nrp_core.recording.layout import device_topic
from nrp_core.utilities import replace_file, writing

SUFFIX: Final = ".cockpit.json"
"""The suffix of a layout's file."""
_WHAT: Final = "a layout"
_DEVICES: Final = device_topic("", "")
_TEXTS: Final = ("string", "wstring")
_STEP: Final = re.compile(r"([^.\[\]]+)(\[\d+\])?")


class Layout:
    """The layout of the page: where its panels are, and the curves of its plots.

    Each user's changes are saved in their folder of settings. The preset is written only on request, because
    the folder of an experiment is shared.

    Args:
        path: the file of the preset; None: do not save it.
        channels: the channels that the page can plot.
    """

    def __init__(self, path: Path | None, channels: Channels) -> None:
        self._path, self._channels = path, channels
        self._own = None if path is None else own_layout(path)

    def load(self) -> dict[str, Any]:
        """Return the ``layout``, if the page can use it, and its ``problem``, if any.

        Curves of unknown topics or fields are a problem and stay: a later change of the run may offer them.
        """
        path = self._own if self._own is not None and self._own.exists() else self._path
        if path is None or not path.exists():
            return {}
        try:
            arrangement, tree = read_form(path, Arrangement, _WHAT)
        except ExperimentError as error:
            return {"problem": f"{error}; the page has its usual layout"}
        found = {"layout": arrangement.model_dump(mode="json", exclude_defaults=True)}
        for i, curve in enumerate(arrangement.traces):
            for key, flaw in self._flaws(curve):
                return found | {"problem": str(tree.place_of("traces", i, key).error(flaw))}
        return found

    def save(self, layout: dict[str, Any]) -> None:
        """Write the user's layout.

        Raises:
            ExperimentError: it is none, or the folder cannot be written.
        """
        _write(self._own, layout)

    def preset(self, layout: dict[str, Any]) -> None:
        """Write the preset, which the user's page then uses.

        Raises:
            ExperimentError: it is none, or the folder cannot be written.
        """
        _write(self._path, layout)
        self.reset()

    def reset(self) -> dict[str, Any]:
        """Remove the user's layout and return the preset, as :meth:`load` does."""
        if self._own is not None:
            self._own.unlink(missing_ok=True)
        return self.load()

    def _flaws(self, curve: Curve) -> Iterator[tuple[str, str]]:
        """Yield the curves that the run cannot show, with the key that requests each."""
        topic, path = curve.topic, curve.path
        if topic.startswith(_DEVICES) and not any(each.topic.startswith(_DEVICES) for each in self._channels):
            return  # transfer functions do not exist yet
        if topic not in self._channels:
            known = [channel.topic for channel in self._channels if channel.encoding == "cdr"]
            yield "topic", f"nothing is offered on the topic '{topic}' of a curve{did_you_mean(topic, known)}"
        elif hint := _missing_field(self._channels[topic], path):
            yield "path", f"messages on {topic} have no number '{path}' for a curve{hint}"


def own_layout(preset: Path) -> Path:
    """Return the file of the user's layout for the experiment or the recording with a preset."""
    name = preset.name.removesuffix(SUFFIX)
    digest = hashlib.sha256(str(preset.absolute()).encode()).hexdigest()[:16]
    return user_config_path("nrp-core") / "cockpit" / f"{name}-{digest}.json"


def _write(path: Path | None, layout: dict[str, Any]) -> None:
    form_of(tree_of(layout), Arrangement, _WHAT)
    if path is None:
        return
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    replace_file(path, json.dumps(layout, indent=2) + "\n")


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
