"""Write a model in canonical form: one element a line, in the order of the metamodel, without defaults."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from nrp_bibi.model.functions import Bibi
from nrp_bibi.model.metamodel import Feature, Node, Value, features
from nrp_core.errors import TransferFunctionError
from nrp_core.utilities import replace_file

NAMESPACE = "http://schemas.humanbrainproject.eu/SP10/2014/BIBI"
_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_ESCAPES = {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}


def write_bibi(model: Bibi, path: Path) -> None:
    """Write a file as a whole; see :func:`bibi_text`.

    Raises:
        ExperimentError: the disk refused it.
    """
    replace_file(path, bibi_text(model))


def bibi_text(model: Bibi) -> str:
    """Return a model as a document; reading it gives an equal model.

    Raises:
        TransferFunctionError: a text has characters that XML does not allow.
    """
    spaces = [f'xmlns="{NAMESPACE}"', f'xmlns:xsi="{_XSI}"']
    lines = _element("bibi", model, type_name="", more=spaces)
    return "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', *lines, ""])


def _element(tag: str, node: Node, type_name: str, more: list[str]) -> Iterator[str]:
    given = [(feature, getattr(node, feature.field)) for feature in features(type(node))]
    given = [(feature, value) for feature, value in given if value != _default(type(node), feature)]
    head = [tag, *more]
    if type_name:
        head.append(f'xsi:type="{type_name}"')
    head += [f'{f.name}="{escaped(_text(f, value))}"' for f, value in given if f.place == "attribute"]
    inner = [line for f, value in given if f.place == "element" for line in _elements(f, value)]
    text = next((value for feature, value in given if feature.place == "content"), "")
    if text:
        yield f"<{' '.join(head)}>{_content(text)}</{tag}>"
    elif inner:
        yield f"<{' '.join(head)}>"
        yield from (f"  {line}" for line in inner)
        yield f"</{tag}>"
    else:
        yield f"<{' '.join(head)}/>"


def _elements(feature: Feature, value: Any) -> Iterator[str]:
    for one in value if feature.many else (value,):
        if isinstance(feature.of, Value):
            yield f"<{feature.name}>{escaped(feature.of.show(one))}</{feature.name}>"
        else:
            type_name = type(one).__name__ if feature.of.abstract else ""
            yield from _element(feature.name, one, type_name, [])


def _content(text: str) -> str:
    """Return the text of an element; code of several lines is unchanged."""
    if "\n" not in text:
        return escaped(text)
    _refuse_forbidden(text)
    return "<![CDATA[\n" + text.replace("]]>", "]]]]><![CDATA[>") + "\n]]>"


def _default(node: type[Node], feature: Feature) -> Any:
    return node.__dataclass_fields__[feature.field].default


def _text(feature: Feature, value: Any) -> str:
    assert isinstance(feature.of, Value)
    return feature.of.show(value)


def escaped(text: str) -> str:
    """Return a text as it stands in XML, in an attribute or between elements."""
    _refuse_forbidden(text)
    return "".join(_ESCAPES.get(character, character) for character in text)


def _refuse_forbidden(text: str) -> None:
    found = _FORBIDDEN.search(text)
    if found:
        raise TransferFunctionError(f"XML does not allow the character {found[0]!r} in {text!r:.60}")
