"""Labels: the classes of visuals for segmentation cameras, by gz-sim's ``Label`` plugin."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from nrp_core.world.scene.model import Link
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.xml import Element

LABEL = "Label"
"""The plugin, of a visual or of a whole model."""
_HIGHEST = 255
"""The labels of an image have 8 bits."""


def label_in(plugin: Element) -> int:
    """Return the label that a plugin gives.

    Raises:
        SceneError: it is not a whole number from 0 to 255.
    """
    given = plugin.require("label")
    (label,) = given.numbers(1)
    if label != int(label) or not 0 <= label <= _HIGHEST:
        raise given.error(f"a <label> is a whole number from 0 to {_HIGHEST}, not {given.text}")
    return int(label)


def label_of(visual: Element) -> int:
    """Return the label of a ``<visual>``, 0 for none."""
    plugins = [each for each in visual.all("plugin") if plugin_name(each) == LABEL]
    return label_in(plugins[0]) if plugins else 0


def labelled(links: Iterable[Link], label: int) -> list[Link]:
    """Return links; visuals without a label get one."""
    return [
        replace(
            link,
            visuals=tuple(replace(each, label=each.label or label) for each in link.visuals),
        )
        for link in links
    ]
