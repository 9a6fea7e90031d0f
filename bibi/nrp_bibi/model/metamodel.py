"""Declare the XML form of model classes once, for reader, writer and schema.

::

    @dataclass(frozen=True, slots=True, kw_only=True)
    class Index(NeuronSelector):
        index: int = attribute(NATURAL)

is ``<... xsi:type="Index" index="3"/>``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, ClassVar, Literal

_FEATURE = "feature"


@dataclass(frozen=True, slots=True)
class Value:
    """The type of a value that an attribute or element holds as text.

    Args:
        name: the name of its simple type in the schema.
        parse: returns the value of a text, or raises ValueError.
        show: returns the canonical text of a value.
        expects: a description of valid texts, for messages.
        facets: the body of the schema's restriction: ``base type`` and facets in order.
    """

    name: str
    parse: Callable[[str], Any]
    show: Callable[[Any], str]
    expects: str
    facets: tuple[tuple[str, str], ...]


Place = Literal["attribute", "element", "content"]


@dataclass(frozen=True, slots=True)
class Feature:
    """A field of a class and its place in XML.

    Args:
        field: the name in the class.
        name: the name in XML.
        of: the type of its value, or the class of its element.
        place: where the writer puts it; the reader takes attributes and elements.
        many: whether several are allowed.
        least: the minimum number.
        aliases: other names in XML, each with the type that it implies, or an empty text.
        bare: whether it may also be the plain text of its owner.
        unit: of a number, for people.
    """

    field: str
    name: str
    of: Value | type[Node]
    place: Place
    many: bool
    least: int
    aliases: Mapping[str, str]
    bare: bool
    unit: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """All its names in XML."""
        return (self.name, *self.aliases)


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """A part of a model; equality ignores the position in the file.

    Args:
        line: its line in the file, 0 if it has no file.
    """

    line: int = field(default=0, compare=False, repr=False)

    abstract: ClassVar[bool] = False

    def __init_subclass__(cls, abstract: bool = False) -> None:
        # @dataclass(slots=True) creates the class again, without its keyword arguments
        cls.abstract = abstract or cls.__dict__.get("abstract", False)


def attribute(of: Value, default: Any = dataclasses.MISSING, name: str = "", unit: str = "") -> Any:
    """Declare a value that is written as an attribute; without a default it is required."""
    return _declared("attribute", of, name=name, default=default, unit=unit)


def child(
    of: Value | type[Node],
    default: Any = dataclasses.MISSING,
    *,
    name: str = "",
    aliases: Mapping[str, str] | None = None,
    bare: bool = False,
    unit: str = "",
) -> Any:
    """Declare one element; without a default it is required."""
    return _declared("element", of, name=name, default=default, aliases=aliases, bare=bare, unit=unit)


def children(
    of: Value | type[Node], *, name: str = "", aliases: Mapping[str, str] | None = None, least: int = 0
) -> Any:
    """Declare elements of one name, kept as a tuple of at least ``least`` items."""
    default = dataclasses.MISSING if least else ()
    return _declared("element", of, name=name, default=default, aliases=aliases, many=True, least=least)


def content(of: Value, default: Any = dataclasses.MISSING) -> Any:
    """Declare that the text of the element itself is a value; ``value`` in XMI."""
    return _declared("content", of, name="value", default=default)


def _declared(
    place: Place,
    of: Value | type[Node],
    *,
    name: str,
    default: Any,
    aliases: Mapping[str, str] | None = None,
    many: bool = False,
    least: int = 1,
    bare: bool = False,
    unit: str = "",
) -> Any:
    least = least if default is dataclasses.MISSING else 0
    feature = Feature("", name, of, place, many, least, aliases or {}, bare, unit)
    return field(default=default, metadata={_FEATURE: feature})


def features(node: type[Node]) -> tuple[Feature, ...]:
    """Return the features of a class, in the order in which they are written."""
    declared = [(item.name, item.metadata.get(_FEATURE)) for item in dataclasses.fields(node)]
    named = [
        dataclasses.replace(feature, field=name, name=feature.name or _camel(name))
        for name, feature in declared
        if feature is not None
    ]
    return tuple(sorted(named, key=lambda feature: feature.place != "attribute"))


def concrete(node: type[Node]) -> dict[str, type[Node]]:
    """Return the classes that an element declared as ``node`` can be, by their names in XML."""
    own = {} if node.abstract else {node.__name__: node}
    # Dataclasses with slots are created twice; the last one of a name is the one in the module.
    below = {name: found for sub in node.__subclasses__() for name, found in concrete(sub).items()}
    return own | below


def choice(name: str, members: type[Enum], others: Mapping[str, Enum] | None = None) -> Value:
    """Return the value type of an enumeration; the reader ignores case and underscores."""
    known = {_folded(member.value): member for member in members}
    known |= {_folded(text): member for text, member in (others or {}).items()}

    def parse(text: str) -> Enum:
        if _folded(text) not in known:
            raise ValueError
        return known[_folded(text)]

    valid = [str(member.value) for member in members]
    facets = (("base", "xs:string"), *(("enumeration", text) for text in valid))
    return Value(name, parse, lambda member: str(member.value), f"one of {', '.join(valid)}", facets)


def _folded(text: str) -> str:
    return text.strip().replace("_", "").lower()


def _camel(name: str) -> str:
    first, *rest = name.rstrip("_").split("_")
    return first + "".join(map(str.capitalize, rest))
