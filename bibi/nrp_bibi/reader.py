"""Read a BIBI document, in any of its historical forms.

Elements are identified by their local names, in any order, with any prefix and namespace; a value may
be an attribute or an element, as XMI writes it. Only content that cannot be understood is refused.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from nrp_bibi.model.functions import Bibi
from nrp_bibi.model.metamodel import Feature, Node, Value, concrete, features
from nrp_core.errors import ExperimentError, TransferFunctionError, did_you_mean
from nrp_core.xml import Element, parse_xml, read_xml

_ROOTS = {"bibi", "BIBIConfiguration", "Bibi"}


def read_bibi(path: Path) -> Bibi:
    """Read a file.

    Raises:
        TransferFunctionError: it cannot be read, or part of it is not valid; the error names the line.
    """
    return model_of(read_xml(path, TransferFunctionError))


def parse_bibi(text: bytes | str, path: Path = Path("<text>")) -> Bibi:
    """Read a document; ``path`` is for messages.

    Raises:
        TransferFunctionError: part of it is not valid; the error names the line.
    """
    encoded = text.encode() if isinstance(text, str) else text
    return model_of(parse_xml(encoded, path, TransferFunctionError))


def model_of(root: Element) -> Bibi:
    """Return the model of a document, given its root element.

    Raises:
        TransferFunctionError: part of it is not valid; the error names the line.
    """
    if _local(root.tag) == "XMI":
        found = [child for child in root.children if _local(child.tag) in _ROOTS]
        if len(found) != 1:
            raise root.error(f"<{root.tag}> holds {len(found)} BIBI models instead of one")
        root = found[0]
    if _local(root.tag) not in _ROOTS:
        raise root.error(f"a BIBI document begins with <bibi>, not <{root.tag}>")
    model: Bibi = _Reading(_in_present_form(root), Bibi).node()
    return model


def _in_present_form(element: Element) -> Element:
    """Return an element of any year as it would be written in the last version.

    References ``name="device.voltage"`` get a name and a property, patterns of a ``MapSelector`` the
    population of its source, and a ``<file>`` without a name is dropped.
    """
    given = dict(element.attributes)
    name, dot, path = given.get("name", "").partition(".")
    if dot and _stated_type(element) == "ArgumentReference" and "property" not in given:
        given |= {"name": name, "property": path}
    inner = [_in_present_form(child) for child in element.children if not _is_empty_file(child)]
    if _stated_type(element) == "MapSelector":
        sources = [child for child in inner if _local(child.tag) == "source"]
        population = {
            key: one.attributes[key] for one in sources for key in ("population",) if key in one.attributes
        }
        inner = [
            replace(child, attributes={**population, **child.attributes})
            if _local(child.tag) == "pattern"
            else child
            for child in inner
        ]
    return replace(element, attributes=given, children=inner)


def _is_empty_file(element: Element) -> bool:
    return _local(element.tag) == "file" and not (element.text or element.attributes or element.children)


class _Reading:
    """The reading of one element as one class."""

    def __init__(self, element: Element, of: type[Node], implied: str = "") -> None:
        self._element = element
        self._given = {_local(name) for name in (*_own(element.attributes), *_tags(element))}
        self._class = self._class_of(of, implied)
        self._features = features(self._class)

    def node(self) -> Any:
        """Return the element as an object."""
        self._refuse_unknown()
        values = {feature.field: self._value(feature) for feature in self._features if self._has(feature)}
        element = self._element
        for feature in self._features:
            given = values.get(feature.field, ())
            if (len(given) if feature.many else feature.field in values) < feature.least:
                raise element.error(f"<{element.tag}> needs {_wanted(feature)}")
            line_of = f"{feature.field}_line"
            if feature.place == "content" and line_of in self._class.__dataclass_fields__:
                values[line_of] = _first_line(element)
        return self._class(line=element.line, **values)

    # -- the class

    def _class_of(self, of: type[Node], implied: str) -> type[Node]:
        choices = concrete(of)
        name = _stated_type(self._element) or implied
        if name in choices:
            return choices[name]
        if name and not (of is Bibi and name in _ROOTS):
            raise _wrong_type(self._element, name, choices)
        fitting = [choice for choice in choices.values() if self._fits(choice)]
        if len(choices) == 1 or len(fitting) == 1:
            return (fitting or list(choices.values()))[0]
        raise self._element.error(
            f"<{self._element.tag}> needs xsi:type; valid: {', '.join(sorted(choices))}"
        )

    def _fits(self, choice: type[Node]) -> bool:
        known = {name for feature in features(choice) for name in feature.names}
        needed = (feature.names for feature in features(choice) if feature.least)
        return known.issuperset(self._given) and all(map(self._given.intersection, needed))

    # -- the content

    def _refuse_unknown(self) -> None:
        element = self._element
        known = {name for feature in self._features for name in feature.names}
        for name in _own(element.attributes):
            if _local(name) not in known:
                raise element.error(f"<{element.tag}> has no attribute '{name}'{did_you_mean(name, known)}")
        for child in element.children:
            if _local(child.tag) not in known:
                raise child.error(
                    f"<{element.tag}> has no element <{child.tag}>{did_you_mean(_local(child.tag), known)}"
                )
        takes_text = any(feature.bare or feature.place == "content" for feature in self._features)
        if element.text and not takes_text:
            raise element.error(f"<{element.tag}> cannot contain text, such as '{element.text:.40}'")

    def _has(self, feature: Feature) -> bool:
        if any(name in self._given for name in feature.names):
            return True
        return bool(self._element.text) and (feature.bare or feature.place == "content")

    def _value(self, feature: Feature) -> Any:
        attribute = next(
            (v for k, v in _own(self._element.attributes).items() if _local(k) in feature.names), None
        )
        elements = [child for child in self._element.children if _local(child.tag) in feature.names]
        if isinstance(feature.of, Value):
            values = self._texts(feature, feature.of, attribute, elements)
        elif attribute is not None:
            raise self._element.error(
                f"'{feature.name}' of <{self._element.tag}> must be an element, not an attribute"
            )
        else:
            implied = feature.aliases
            values = [
                _Reading(child, feature.of, implied.get(_local(child.tag), "")).node() for child in elements
            ]
        if feature.many:
            return tuple(values)
        if len(values) > 1:
            raise self._element.error(f"<{self._element.tag}> has '{feature.name}' more than once")
        return values[0]

    def _texts(
        self, feature: Feature, kind: Value, attribute: str | None, elements: list[Element]
    ) -> list[Any]:
        here = self._element
        found = [] if attribute is None else [(here, text) for text in self._split(attribute, feature)]
        for element in elements:
            _check_value_element(element, kind)
            found.append((element, element.raw_text))
        if not found:
            found = [(here, here.raw_text)]
        return [_parsed(place, feature.name, kind, text) for place, text in found]

    def _split(self, text: str, feature: Feature) -> list[str]:
        """Return the texts in an attribute; XMI writes several values into one attribute."""
        return text.split() if feature.many else [text]


def _check_value_element(element: Element, kind: Value) -> None:
    """Refuse child elements, attributes and a wrong ``xsi:type`` of an element that holds a plain value."""
    if element.children:
        raise element.error(f"<{element.tag}> holds {kind.expects}, not elements")
    for name in _own(element.attributes):
        raise element.error(f"<{element.tag}> has no attribute '{name}': it holds {kind.expects}")
    base = _local(kind.facets[0][1])
    name = _stated_type(element)
    if name not in ("", kind.name, base, "string"):
        raise _wrong_type(element, name, (kind.name, base))


def _wrong_type(element: Element, name: str, valid: Iterable[str]) -> ExperimentError:
    return element.error(f"<{element.tag}> cannot have xsi:type '{name}'{did_you_mean(name, valid)}")


def _parsed(element: Element, name: str, kind: Value, text: str) -> Any:
    try:
        return kind.parse(text)
    except ValueError:
        raise _refusal(element, name, kind, text) from None


def _refusal(element: Element, name: str, kind: Value, text: str) -> ExperimentError:
    valid = [value for facet, value in kind.facets if facet == "enumeration"]
    hint = did_you_mean(text, valid) if valid else f"; it must be {kind.expects}"
    what = f"<{element.tag}>" if _local(element.tag) == name else f"'{name}' of <{element.tag}>"
    return element.error(f"{what} cannot be '{text.strip():.60}'{hint}")


def _wanted(feature: Feature) -> str:
    if feature.place == "attribute":
        return f'an attribute {feature.name}="..."'
    if feature.place == "content":
        return "text"
    return f"a <{feature.name}>" if feature.least == 1 else f"at least {feature.least} <{feature.name}>"


def _first_line(element: Element) -> int:
    """Return the line of the first text of an element, after blank lines."""
    blank = element.raw_text[: len(element.raw_text) - len(element.raw_text.lstrip())]
    return element.end_line - element.raw_text.count("\n") + blank.count("\n")


def _own(attributes: dict[str, str]) -> dict[str, str]:
    """Return the attributes without a prefix; XML, XSI and XMI attributes have one."""
    return {name: text for name, text in attributes.items() if ":" not in name and name != "xmlns"}


def _tags(element: Element) -> list[str]:
    return [child.tag for child in element.children]


def _stated_type(element: Element) -> str:
    """Return the local name of the ``xsi:type``, empty where there is none."""
    return next((_local(text) for name, text in element.attributes.items() if _says_type(name)), "")


def _says_type(attribute: str) -> bool:
    return ":" in attribute and _local(attribute) == "type"


def _local(name: str) -> str:
    return name.rpartition(":")[2]
