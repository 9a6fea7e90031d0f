"""The XML schema of BIBI documents, ``bibi.xsd``, written from the metamodel.

``python -m nrp_bibi.schema`` writes it again. It accepts elements in any order and under all their names. The
reader checks what a schema cannot express, such as a required element where any order is allowed.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from nrp_bibi.model.functions import Bibi
from nrp_bibi.model.metamodel import Feature, Node, Value, concrete, features
from nrp_bibi.templates import environment
from nrp_bibi.writer import NAMESPACE, escaped

SCHEMA = Path(__file__).with_name("bibi.xsd")


def schema_text() -> str:
    """Return the schema."""
    types, values = _reachable(Bibi)
    template = environment().get_template("bibi.xsd.j2")
    text = template.render(
        namespace=NAMESPACE, types=map(_Type.of, types), values=values, escaped=escaped, summary=_summary
    )
    return re.sub(r"\n +(?=\n)", "", text)


@dataclass(frozen=True, slots=True)
class _Type:
    """A class in the schema; the declarations of abstract classes are repeated in the concrete ones."""

    node: type[Node]
    base: type[Node] | None
    attributes: list[tuple[Feature, str]]
    elements: list[tuple[str, str]]
    is_mixed: bool

    @classmethod
    def of(cls, node: type[Node]) -> _Type:
        """Describe a class."""
        own = () if node.abstract else features(node)
        return cls(
            node=node,
            base=_base(node),
            attributes=[(f, _name(f.of)) for f in own if f.place == "attribute"],
            elements=[pair for f in own if f.place == "element" for pair in _elements(f)],
            is_mixed=any(f.place == "content" or f.bare for f in own),
        )


def _elements(feature: Feature) -> list[tuple[str, str]]:
    """Return all names of an element, each with its type."""
    return [(name, feature.aliases.get(name) or _name(feature.of)) for name in feature.names]


def _reachable(root: type[Node]) -> tuple[list[type[Node]], list[Value]]:
    """Return every class and value type that a document can contain, in order of appearance."""
    types: dict[str, type[Node]] = {}
    values: dict[str, Value] = {}
    todo: list[type[Node] | None] = [root]
    while todo:
        node = todo.pop(0)
        if node is None or node.__name__ in types:
            continue
        types[node.__name__] = node
        todo += [_base(node), *(concrete(node).values() if node.abstract else ())]
        for feature in () if node.abstract else features(node):
            if not isinstance(feature.of, Value):
                todo.append(feature.of)
            elif feature.place != "content":
                values[feature.of.name] = feature.of
    return list(types.values()), list(values.values())


def _base(node: type[Node]) -> type[Node] | None:
    base = node.__bases__[0]
    return base if issubclass(base, Node) and base is not Node else None


def _name(of: Value | type[Node]) -> str:
    return of.name if isinstance(of, Value) else of.__name__


def _summary(node: type[Node]) -> str:
    return (node.__doc__ or "").partition("\n")[0].replace("``", "")
