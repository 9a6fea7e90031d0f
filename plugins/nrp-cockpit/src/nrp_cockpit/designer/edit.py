"""The commands that change a model; each makes a new model and leaves the old one as it is."""

from __future__ import annotations

import ast
import re
from dataclasses import replace
from typing import Any

from nrp_bibi.generate.walk import channels
from nrp_bibi.model.expressions import ArgumentReference, FlowExpression
from nrp_bibi.model.functions import Bibi, BIBITransferFunction
from nrp_bibi.model.metamodel import Feature, Node, Value, concrete, features
from nrp_bibi.reverse.expressions import as_expression
from nrp_bibi.reverse.refusal import NotExpressibleError

from nrp_cockpit.designer.fresh import Fresh
from nrp_cockpit.designer.surroundings import Surroundings
from nrp_cockpit.designer.tree import at, feature_of, function_of, parent_of, replaced, walk
from nrp_core.errors import ExperimentError, did_you_mean


class Edit:
    """Changes of a model.

    Args:
        model: the model as it is.
        surroundings: what it is drawn between.

    Attributes:
        model: the model as it is now.
        selected: the path of what was made last, which the page then shows.
    """

    def __init__(self, model: Bibi, surroundings: Surroundings) -> None:
        self.model, self.surroundings = model, surroundings
        self.selected: str | None = None

    def set(self, path: str, field: str, text: str | None) -> None:
        """Give a value, as it stands in XML; None or an empty text is the default, if there is one.

        The new name of a channel or local is also written where expressions refer to it.
        """
        node = at(self.model, path)
        feature = feature_of(node, field)
        if not isinstance(feature.of, Value):
            raise ExperimentError(f"'{feature.name}' is not a value")
        value = self._parsed(node, feature, feature.of, text)
        before = getattr(node, field)
        self.model = replaced(self.model, path, replace(node, **{field: value}))
        function = function_of(path)
        if field == "name" and function not in ("", path):
            self._rename(function, before, value)

    def become(self, path: str, type: str) -> None:  # noqa: A002  the name that the page gives it
        """Make a node one of another class; fields that both have stay."""
        node, feature = at(self.model, path), self._feature_at(path)
        kind = self._class(feature, type)
        kept = {f.field: getattr(node, f.field) for f in features(kind) if _holds(f, node)}
        self.model = replaced(self.model, path, self._fresh(path).make(kind, **kept))

    def add(self, path: str, field: str, type: str | None = None) -> None:  # noqa: A002  likewise
        """Add a new node at the end of a list, or where there is none yet."""
        node = at(self.model, path)
        feature = feature_of(node, field)
        if isinstance(feature.of, Value):
            raise ExperimentError(f"'{feature.name}' is not a part")
        self.put(path, field, self._fresh(path).make(self._class(feature, type)))

    def put(self, path: str, field: str, new: Node) -> None:
        """Put a node at the end of a list, or where there is one or none."""
        below = f"{path}/{field}" if path else field
        feature = feature_of(at(self.model, path), field)
        now = at(self.model, below)
        self.model = replaced(self.model, below, (*now, new) if feature.many else new)
        self.selected = f"{below}/{len(now)}" if feature.many else below

    def write(self, path: str, field: str, text: str) -> None:
        """Give an expression as Python; an empty text takes it away, if it need not be there."""
        node = at(self.model, path)
        feature = feature_of(node, field)
        if not (isinstance(feature.of, type) and issubclass(feature.of, FlowExpression)) or feature.many:
            raise ExperimentError(f"'{feature.name}' is not an expression")
        if not text.strip():
            if feature.least:
                raise ExperimentError(f"'{feature.name}' needs an expression")
            self.model = replaced(self.model, path, replace(node, **{field: None}))
            return
        known = names_in(at(self.model, function_of(path)))
        self.model = replaced(self.model, path, replace(node, **{field: expression_of(text, known)}))

    def remove(self, path: str) -> None:
        """Take a part away."""
        owner = parent_of(path)
        feature = self._feature_at(path)
        held = at(self.model, owner) if feature.many else None
        if (len(held) if held is not None else 1) <= feature.least:
            kind = type(at(self.model, parent_of(owner) if feature.many else owner)).__name__
            raise ExperimentError(f"a {kind} needs its {feature.name}")
        self.model = replaced(self.model, path, None)
        self.selected = function_of(owner) or None

    def move(self, path: str, to: int) -> None:
        """Move an item to another place in its list."""
        owner, _, last = path.rpartition("/")
        if not last.isdigit():
            raise ExperimentError("only an item of a list can be moved")
        place = int(last)
        items = list(at(self.model, owner))
        items.insert(min(max(to, 0), len(items) - 1), items.pop(place))
        self.model = replaced(self.model, owner, tuple(items))
        self.selected = f"{owner}/{min(max(to, 0), len(items) - 1)}"

    def copy(self, path: str) -> None:
        """Add a copy of an item to its list, under a name of its own."""
        node, owner = at(self.model, path), parent_of(path)
        if not isinstance(at(self.model, owner), tuple):
            raise ExperimentError("there can be only one of this")
        if getattr(node, "name", None) and any(f.field == "name" for f in features(type(node))):
            node = replace(node, name=self._fresh(parent_of(owner)).name(node.name))
        self.put(parent_of(owner), owner.rpartition("/")[2], node)

    # --

    def function(self, path: str) -> BIBITransferFunction | None:
        """Return the function of building blocks that something is part of."""
        found = at(self.model, function_of(path)) if function_of(path) else None
        return found if isinstance(found, BIBITransferFunction) else None

    def _fresh(self, path: str) -> Fresh:
        return Fresh(self.model, self.surroundings, self.function(path))

    def _feature_at(self, path: str) -> Feature:
        """Return the feature that holds what is at a path."""
        owner, _, last = path.rpartition("/")
        if last.isdigit():
            owner, _, last = owner.rpartition("/")
        return feature_of(at(self.model, owner), last)

    def _class(self, feature: Feature, name: str | None) -> type[Node]:
        assert isinstance(feature.of, type)
        choices = concrete(feature.of)
        if name is None:
            return feature.of
        if name not in choices:
            raise ExperimentError(f"'{feature.name}' cannot be a '{name}'{did_you_mean(name, choices)}")
        return choices[name]

    def _parsed(self, node: Node, feature: Feature, kind: Value, text: str | None) -> Any:
        if feature.many:
            values = tuple(_value(feature, kind, one) for one in (text or "").replace(",", " ").split())
            if len(values) < feature.least:
                raise ExperimentError(f"'{feature.name}' needs {kind.expects}")
            return values
        if text is None or (text == "" and kind.name != "Text"):
            if feature.least:
                raise ExperimentError(f"'{feature.name}' is needed: {kind.expects}")
            return node.__dataclass_fields__[feature.field].default
        return _value(feature, kind, text)

    def _rename(self, function: str, before: str | None, after: str | None) -> None:
        for path, part in list(walk(at(self.model, function), function)):
            if isinstance(part, ArgumentReference) and part.name == before and after:
                self.model = replaced(self.model, path, replace(part, name=after))


def names_in(function: Node) -> list[str]:
    """Return the names that expressions of a function can refer to."""
    if not isinstance(function, BIBITransferFunction):
        return []
    return [str(part.name) for part in (*channels(function), *function.local) if part.name]


def expression_of(text: str, known: list[str]) -> FlowExpression:
    """Return a Python expression as building blocks.

    Raises:
        ExperimentError: it is not one, or says more than blocks can.
    """
    try:
        return as_expression(ast.parse(text.strip(), mode="eval").body, frozenset(known))
    except SyntaxError as error:
        raise ExperimentError(f"this is not an expression: {error.msg}") from None
    except NotExpressibleError as error:
        what = str(error)
        if re.fullmatch(r"\w+(\.\w+)*", what):
            hint = did_you_mean(what.partition(".")[0], known)
            raise ExperimentError(f"no channel and no local of this function is '{what}'{hint}") from None
        raise ExperimentError(f"'{what}' is more than blocks can say; a Python function can") from None


def _value(feature: Feature, kind: Value, text: str) -> Any:
    try:
        return kind.parse(text)
    except ValueError:
        raise ExperimentError(f"'{feature.name}' cannot be '{text:.60}'; it must be {kind.expects}") from None


def _holds(feature: Feature, node: Node) -> bool:
    """Whether a node has a value that fits a feature of another class."""
    for own in features(type(node)):
        if own.field == feature.field and own.many == feature.many:
            same = own.of is feature.of or not (isinstance(own.of, Value) or isinstance(feature.of, Value))
            value = getattr(node, own.field)
            fits = isinstance(feature.of, Value) or value is None or isinstance(value, (feature.of, tuple))
            return same and fits
    return False
