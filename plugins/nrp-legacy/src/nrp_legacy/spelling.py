"""Misspelt and misplaced elements and attributes of the two documents, and words that nothing knows.

The platform accepted unknown elements, and files have them. So only those are reported that are nearly those
of a document, or those of another element of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from typing import Final

from nrp_core._support.xml import Element
from nrp_core.findings import Code, Finding, Level
from nrp_legacy.documents import FUNCTION
from nrp_legacy.elements import attribute, local, text

_FILE: Final = "@model @assetPath @customAsset @customModelPath @isCustom @src file src"
_SELECTOR: Final = "@type @population @from @to @step @count element"
_TABLE: Final = {
    "ExD": "name description thumbnail tags timeout configuration maturity environmentModel visualModel "
    "bibiConf experimentControl experimentEvaluation cameraPose physicsEngine rngSeed rosLaunch cloneDate "
    "gzbridgesettings events robotPose",
    "environmentModel": f"{_FILE} robotPose",
    "robotPose": "@robotId @x @y @z @roll @pitch @yaw @ux @uy @uz @theta",
    "visualModel": "@src @scale visualPose",
    "bibiConf": "@src @processes",
    "timeout": "@time",
    "configuration": "@src @type",
    "rosLaunch": "@src",
    "experimentControl": "stateMachine",
    "experimentEvaluation": "stateMachine",
    "stateMachine": "@type @id @src src",
    "cameraPose": "cameraPosition cameraLookAt",
    "cameraPosition": "@x @y @z",
    "cameraLookAt": "@x @y @z",
    "bibi": "brainModel bodyModel extRobotController configuration connectors synapseDynamics "
    "transferFunction transferFunctionImport transferFunctionInline timestep mode",
    "brainModel": f"{_FILE} populations neuronGroup",
    "bodyModel": f"@robotId {_FILE}",
    "populations": _SELECTOR,
    "neuronGroup": _SELECTOR,
    "transferFunction": "@type @src @active @priority @name src local device deviceGroup topic returnValue",
    **dict.fromkeys(("name", "physicsEngine", "rngSeed", "timestep", "mode", "file"), ""),
}
_ATTRIBUTES: Final = {
    tag: tuple(word[1:] for word in entry.split() if word[0] == "@") for tag, entry in _TABLE.items()
}
_CHILDREN: Final = {
    tag: tuple(word for word in entry.split() if word[0] != "@") for tag, entry in _TABLE.items()
}
_WORDS: Final = {
    FUNCTION: ("PythonTransferFunction", "Neuron2Robot", "Robot2Neuron", "Neuron2Monitor"),
    "stateMachine": ("SMACHStateMachine", "SCXMLStateMachine"),
}
"""The types of elements."""
_OF_MODE: Final = (
    *("Synchronous", "Asynchronous", "Pynn", "Nest", "Direct", "Spinnaker", "Nengo", "Music", "Client"),
    "Simulation",
)
"""The words of which modes are made."""
_LEFT_OUT: Final = {
    "environmentModel": Code.NRP257,
    "experimentControl": Code.NRP273,
    "experimentEvaluation": Code.NRP273,
    "stateMachine": Code.NRP273,
    "bodyModel": Code.NRP256,
    "brainModel": Code.NRP269,
    FUNCTION: Code.NRP272,
}
"""What a run lacks whose element is misspelt or misplaced."""


def slips_in(root: Element, entry: str) -> Iterator[Finding]:
    """Yield the slips in a document.

    Args:
        root: its root.
        entry: the name that the root should have.
    """
    tag = local(root.tag)
    if tag != entry and _near(tag, [entry]):
        yield _finding(root, f"the document begins with <{tag}>; did you mean <{entry}>?")
    yield from _slips(root, entry)
    for word in re.findall("[A-Z]?[a-z]+", text(root, "mode")):
        if word not in _OF_MODE and (near := _near(word, _OF_MODE)):
            yield _finding(
                root, f"the <mode> '{text(root, 'mode')}' is not known: is '{word}' meant as '{near}'?"
            )


def _slips(parent: Element, entry: str) -> Iterator[Finding]:
    yield from _attributes(parent, entry)
    for element in parent.children:
        tag = FUNCTION if local(element.tag).startswith(FUNCTION) else local(element.tag)
        if tag not in _CHILDREN[entry]:
            yield from _unknown(element, tag, parent, entry)
        elif tag in _TABLE:
            yield from _slips(element, tag)


def _unknown(element: Element, tag: str, parent: Element, entry: str) -> Iterator[Finding]:
    holders = [f"<{name}>" for name, children in _CHILDREN.items() if tag in children]
    if holders:
        hint = f"<{tag}> in <{local(parent.tag)}> is ignored; it belongs in {' or '.join(holders)}"
        yield _finding(element, hint, _LEFT_OUT.get(tag, Code.NRP287))
    elif meant := _near(tag, _CHILDREN[entry]):
        message = f"<{tag}> is ignored; did you mean <{meant}>?"
        yield _finding(element, message, _LEFT_OUT.get(meant, Code.NRP287))


def _attributes(element: Element, entry: str) -> Iterator[Finding]:
    """Yield the attributes that nearly have the names of those that are read, and types nearly known."""
    given = [local(name) for name in element.attributes]
    for name in given:
        near = _near(name, [one for one in _ATTRIBUTES[entry] if one not in given], 0.7)
        if near and name not in _ATTRIBUTES[entry]:
            yield _finding(element, f"the attribute '{name}' is ignored; did you mean '{near}'?")
    kind = local(attribute(element, "type") or "")
    if kind not in _WORDS.get(entry, ()) and (near := _near(kind, _WORDS.get(entry, ()))):
        yield _finding(element, f"the type of <{local(element.tag)}> is '{kind}'; did you mean '{near}'?")


def _near(word: str, known: Iterable[str], cutoff: float = 0.8) -> str:
    """Return the known word that is nearly another one, in whatever case; empty for none."""
    spelt = {one.lower(): one for one in known}
    exchanged = [one for one in spelt if sorted(one) == sorted(word.lower())]
    near = exchanged or get_close_matches(word.lower(), spelt, n=1, cutoff=cutoff)
    return spelt[near[0]] if near else ""


def _finding(element: Element, message: str, code: Code = Code.NRP287) -> Finding:
    return Finding(code, message, Level.WARNING, element.path, element.line)
