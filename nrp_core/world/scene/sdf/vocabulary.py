"""Elements and attributes that are not of SDF, values of the wrong kind, and effects that are not simulated.

All of them cause a warning, so that typing errors are found. Elements of other namespaces (``gz:...``) are
accepted, as the specification requires.
"""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from math import isnan
from typing import Final

from nrp_core.errors import SceneError, did_you_mean, slip_of
from nrp_core.findings import Code
from nrp_core.world.rigid.pose import ROUNDED_TURN_RAD
from nrp_core.world.scene.bodies import TINTS
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.parameters import without_truth_value
from nrp_core.world.scene.reading.plugins import wrong_file
from nrp_core.world.scene.reading.repairs import MASSLESS
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.grammar import RULES, Rule

# elements of the specification that no backend simulates, with the values that have no effect
_NOT_SIMULATED: dict[tuple[str, str], tuple[str, ...]] = {
    ("world", "actor"): (),
    ("world", "population"): (),
    ("world", "road"): (),
    ("wind", "linear_velocity"): ("", "0 0 0"),
    ("model", "gripper"): (),
    ("model", "enable_wind"): ("0", "false"),
    ("model", "self_collide"): ("", "0", "false"),
    ("link", "audio_source"): (),
    ("link", "enable_wind"): ("0", "false"),
    ("link", "self_collide"): ("", "0", "false"),
    ("link", "kinematic"): ("0", "false"),
    ("link", "light"): (),
    ("link", "particle_emitter"): (),
    ("link", "projector"): (),
    ("inertial", "fluid_added_mass"): (),
    ("spot", "falloff"): ("1", "1.0"),
    **{
        (workflow, f"{kind}_map"): ("",)
        for workflow in ("metal", "specular")
        for kind in ("environment", "ambient_occlusion", "normal", "emissive", "light")
    },
}

_TRUTH: Final = ("", "0", "1", "false", "true")
_OWN: Final = (MASSLESS, TINTS)
"""Attributes that elements have that were converted from another format."""
_ANY: Final = Rule(free=True)
_COUNTS: Final = {"c": ((3, 4), "3 or 4 numbers"), "p": ((0, 6, 7), "6 numbers")}
"""The counts of numbers in a colour and in a pose, of which an empty one is none."""


def check_vocabulary(element: Element, notes: Notes) -> None:
    """Warn of unknown elements and attributes, those without an effect here, and values of a wrong kind."""
    _check_inside(element, RULES.get(element.tag, _ANY), None, notes)


def _check_inside(element: Element, rule: Rule, around: tuple[Element, Rule] | None, notes: Notes) -> None:
    for child in element.children:
        if ":" in child.tag or rule.free:
            continue
        inner = rule.children.get(child.tag)
        if inner is None:
            hint = _place_of(child, element, rule, around)
            message = f"<{child.tag}> is not an element of <{element.tag}>: ignored{hint}"
            notes.warn(child, Code.NRP263, message, subject=child.tag)
            continue
        problems = [*_attributes(child, inner), *_value(child, inner)]
        if child.tag == "plugin":
            problems += _plugin(child, rule)
        for problem in problems or _without_effect(element, child):
            notes.warn(child, Code.NRP263, problem, subject=child.tag)
        if child.tag == "pose":
            _check_angles(child, notes)
        _check_inside(child, inner, (element, rule), notes)


def _place_of(child: Element, parent: Element, rule: Rule, around: tuple[Element, Rule] | None) -> str:
    """Return the name that was probably meant, or the element that an element belongs in."""
    near = get_close_matches(child.tag, rule.children, n=1)
    if near:
        return f"; did you mean <{near[0]}>?"
    if around is not None and child.tag in around[1].children:
        return f"; it belongs in <{around[0].tag}>, beside <{parent.tag}>"
    holders = [name for name in rule.children if child.tag in rule.children[name].children]
    return f"; it belongs in <{holders[0]}>" if len(holders) == 1 else ""


def _attributes(element: Element, rule: Rule) -> Iterator[str]:
    """Yield the attributes that an element does not have, and words with a slip."""
    for name, text in element.attributes.items():
        if ":" in name or name.startswith("xmlns") or name in _OWN:
            continue
        if name not in rule.attributes:
            hint = did_you_mean(name, rule.attributes) if rule.attributes else ""
            yield f"<{element.tag}> has no attribute '{name}': ignored{hint}"
        elif (words := rule.attributes[name]) and text not in words and (slip := slip_of(text, words)):
            yield f"the {name} of <{element.tag}> is '{text}'{slip}"


def _value(element: Element, rule: Rule) -> Iterator[str]:
    """Yield that a value is of another kind; those that are used are refused where they are read."""
    text = element.text
    if rule.value == "b" and text.lower() not in _TRUTH:
        yield without_truth_value(element)
    elif rule.value == "c" or rule.value == "p" or rule.value.isdigit():
        counts, wanted = _COUNTS.get(rule.value) or _of_count(int(rule.value))
        if not _are_numbers(text) or len(text.split()) not in counts:
            yield f"<{element.tag}> must hold {wanted}, not '{text}': ignored"
    elif not rule.value and not rule.free and text:
        yield f"the text '{text:.40}' in <{element.tag}>, which holds elements, is ignored"


def _plugin(plugin: Element, around: Rule) -> Iterator[str]:
    """Yield that the file of a plugin is misspelt, and the elements in it that belong beside it."""
    if problem := wrong_file(plugin):
        yield problem
    for child in plugin.children:
        beside = around.children.get(child.tag)
        if beside and child.children and (beside.free or beside.children.keys() >= _tags(child)):
            yield f"<{child.tag}> in a <plugin> is ignored; it belongs beside it"


def _tags(element: Element) -> set[str]:
    return {child.tag for child in element.children}


def _of_count(count: int) -> tuple[tuple[int, ...], str]:
    return (count,), "a number" if count == 1 else f"{count} numbers"


def _are_numbers(text: str) -> bool:
    try:
        return not any(isnan(float(word)) for word in text.split())
    except ValueError:
        return False


def check_names(element: Element) -> None:
    """Check that no name contains ``::``, which separates a nested model from its parts.

    Raises:
        SceneError: one does.
    """
    _check_names(element, RULES.get(element.tag, _ANY))


def _check_names(element: Element, rule: Rule) -> None:
    for child in element.children:
        inner = rule.children.get(child.tag, _ANY)
        if inner.free:
            continue
        if "::" in (name := child.attributes.get("name", "")):
            raise child.error(
                f"the name '{name}' must not contain '::', which separates scopes from SDF 1.8 on"
            )
        if child.tag != "state":
            _check_names(child, inner)


def _check_angles(pose: Element, notes: Notes) -> None:
    if pose.is_set("degrees") or pose.attributes.get("rotation_format", "euler_rpy") != "euler_rpy":
        return
    try:
        widest = max(map(abs, pose.numbers(6)[3:]))
    except SceneError:  # empty, or refused where it is read
        return
    if widest > ROUNDED_TURN_RAD:
        message = (
            f"the <pose> {pose.text} has an angle of {widest:g} rad, more than a turn; "
            'is it meant in degrees? In SDF <pose degrees="true"> reads it so; xacro has ${radians(...)}'
        )
        notes.warn(pose, Code.NRP298, message, subject=pose.text)


def _without_effect(parent: Element, child: Element) -> Iterator[str]:
    nothing_special = _NOT_SIMULATED.get((parent.tag, child.tag))
    if nothing_special is not None and child.text.lower() not in nothing_special:
        value = f" {child.text}" if child.text else ""
        yield f"<{child.tag}>{value} of a <{parent.tag}> is not simulated"
