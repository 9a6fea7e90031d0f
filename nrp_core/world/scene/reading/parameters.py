"""Parameters of plugins that have no effect by mistake: misspelt, repeated, or a flag of no truth value.

The reader of a plugin decides which parameters it has: those that it looked for.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from difflib import get_close_matches
from math import isfinite
from typing import Final

from nrp_core.findings import Code
from nrp_core.world.scene.reading.context import Notes, Reading
from nrp_core.world.scene.reading.plugins import plugin_name
from nrp_core.world.scene.reading.xml import Element

_ALIKE: Final = 0.8
"""How alike a tag and a parameter are, from 0 to 1, if one is a misspelling of the other."""
_SAME: Final = 0.88
"""The same where the parameter itself is set too: two letters exchanged or one changed."""
_FLAG: Final = re.compile(
    r"(?!.*(?i:frame|joint|link|name|rate|topic)$)(always|broadcast|enable|initial|is|legacy|publish|use)"
    r"(_|(?=[A-Z]))\w+"
)
_NUMBER: Final = re.compile(r"\w*([a-z]Rate|_rate|Noise|_noise|Frequency|_frequency)")
_TRUTH: Final = ("true", "false")
_FALSE_FRIENDS: Final = ("yes", "no", "on", "off")
_OTHERS: Final = frozenset(
    {
        "body_name", "child_frame_id", "depthImageInfoTopicName", "frameId", "frame_id", "frame_name",
        "max_range", "max_velocity", "min_range", "min_velocity", "odometryFrame", "publishOdomTF",
        "publish_odom_tf", "publish_tf", "rateGaussianNoise", "robot_namespace", "rpy_offset", "updateRateHZ",
        "velocityGain", "velocity_topic_name", "xyz_offset",
    }
)  # fmt: skip
"""Parameters of Gazebo's plugins that have no effect here and resemble one that has."""


def check_parameters(plugin: Element, reading: Reading) -> None:
    """Warn of parameters of a plugin, which has been read, that have no effect by mistake."""
    warn_of_parameters(plugin, reading.notes)


def warn_of_parameters(plugin: Element, notes: Notes) -> None:
    """Do the same where there is no reading yet."""
    for child, problem in _problems(plugin, f"the plugin '{plugin_name(plugin)}'"):
        notes.warn(child, Code.NRP263, problem, subject=child.tag)


def _problems(holder: Element, plugin: str) -> Iterator[tuple[Element, str]]:
    """Yield the parameters in an element with a problem, and the problem."""
    first: dict[str, Element] = {}
    for child in holder.children:
        earlier = first.setdefault(child.tag, child)
        problem = (
            _misspelt(child, holder, plugin) or _no_value(child) or _repeated(child, earlier, holder, plugin)
        )
        if problem:
            yield child, problem
        elif child.tag in holder.asked or child.text:
            for inner in child.children:
                if inner.tag in holder.asked and inner.tag not in child.asked:
                    yield inner, f"<{inner.tag}> in <{child.tag}> is ignored; in {plugin} it stands beside it"
        if child.asked:
            yield from _problems(child, plugin)


def _misspelt(child: Element, holder: Element, plugin: str) -> str:
    if child.tag in holder.asked or child.tag in _OTHERS:
        return ""
    free = holder.asked.keys() - {each.tag for each in holder.children}
    near = [tag for tag in sorted(free) if sorted(tag) == sorted(child.tag)]  # letters exchanged
    near = near or get_close_matches(child.tag, free, n=1, cutoff=_ALIKE)
    near = near or get_close_matches(child.tag, holder.asked, n=1, cutoff=_SAME)
    return f"<{child.tag}> is not a parameter of {plugin}: ignored; did you mean <{near[0]}>?" if near else ""


def _no_value(child: Element) -> str:
    """Report flags and numbers with a slip in their value; most of Gazebo's no reader looks for."""
    text = child.text.lower()
    if child.children or not text:
        return ""
    if _NUMBER.fullmatch(child.tag) and not _is_number(text, several="oise" in child.tag):
        return f"<{child.tag}> is '{child.text}', which is not a number: ignored"
    if text in _TRUTH or not _FLAG.fullmatch(child.tag):
        return ""
    slip = text in _FALSE_FRIENDS or get_close_matches(text, _TRUTH, n=1, cutoff=0.75)
    return without_truth_value(child) if slip else ""


def without_truth_value(flag: Element) -> str:
    """Return the message about a flag with another value."""
    return f"<{flag.tag}> is '{flag.text}', which is neither true nor false: ignored"


def _is_number(text: str, *, several: bool) -> bool:
    """Return whether a text is a number, or several numbers where there may be several."""
    words = text.split()
    try:
        return all(isfinite(float(word)) for word in words) and (several or len(words) == 1)
    except ValueError:
        return False


def _repeated(child: Element, earlier: Element, holder: Element, plugin: str) -> str:
    """Report parameters that the reader takes once and that are given again with another value."""
    if earlier is child or holder.asked.get(child.tag, True) or child.text == earlier.text:
        return ""
    return f"a second <{child.tag}> in {plugin} is ignored: the one of line {earlier.line} is used"
