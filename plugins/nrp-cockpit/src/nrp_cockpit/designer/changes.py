"""Changes of a tree of nodes; each makes a new tree and does not modify the old one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from nrp_bibi.model.metamodel import Feature, Node, Value, concrete, features

from nrp_cockpit.designer.tree import at, feature_of, parent_of, replaced
from nrp_core.errors import ExperimentError, did_you_mean


class Changes(ABC):
    """The commands that fit every model that is drawn.

    Args:
        model: the present model.

    Attributes:
        model: the present model.
        selected: the path of the newest part, which the page then shows.
    """

    def __init__(self, model: Any) -> None:
        self.model = model
        self.selected: str | None = None

    @property
    def commands(self) -> dict[str, Callable[..., None]]:
        """The commands by name."""
        return {"set": self.set, "become": self.become, "add": self.add, "remove": self.remove,
                "move": self.move, "copy": self.copy}  # fmt: skip

    def set(self, path: str, field: str, text: str | None) -> None:
        """Set a value, as in XML; None or an empty text sets the default, if it has one.

        A new name is also written where others refer to it.
        """
        node = at(self.model, path)
        feature = feature_of(node, field)
        if not isinstance(feature.of, Value):
            raise ExperimentError(f"'{feature.name}' is not a value")
        value = self._parsed(node, feature, feature.of, text)
        before = getattr(node, field)
        self.model = replaced(self.model, path, replace(node, **{field: value}))
        if field == "name":
            self._renamed(path, before, value)

    def become(self, path: str, type: str) -> None:  # noqa: A002  the name that the page gives it
        """Make a node one of another class; fields that both have stay."""
        node, feature = at(self.model, path), self._feature_at(path)
        kind = self._class(feature, type)
        kept = {
            f.field: getattr(node, f.field) for f in features(kind) if _holds(f, node) and _is_given(f, node)
        }
        self.model = replaced(self.model, path, self._make(path, kind, **kept))

    def add(self, path: str, field: str, type: str | None = None) -> None:  # noqa: A002  likewise
        """Append a new node to a list, or set an empty feature to it."""
        node = at(self.model, path)
        feature = feature_of(node, field)
        if isinstance(feature.of, Value):
            raise ExperimentError(f"'{feature.name}' is not a part")
        self.put(path, field, self._make(path, self._class(feature, type)))

    def put(self, path: str, field: str, new: Node) -> None:
        """Append a node to a list, or set or replace a single node."""
        below = f"{path}/{field}" if path else field
        feature = feature_of(at(self.model, path), field)
        now = at(self.model, below)
        self.model = replaced(self.model, below, (*now, new) if feature.many else new)
        self.selected = f"{below}/{len(now)}" if feature.many else below

    def remove(self, path: str) -> None:
        """Take a part away."""
        owner = parent_of(path)
        feature = self._feature_at(path)
        held = at(self.model, owner) if feature.many else None
        if (len(held) if held is not None else 1) <= feature.least:
            kind = type(at(self.model, parent_of(owner) if feature.many else owner)).__name__
            raise ExperimentError(f"a {kind} needs its {feature.name}")
        self.model = replaced(self.model, path, None)
        self.selected = self._left(owner)

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
            node = replace(node, name=self._free_name(parent_of(owner), node.name))
        self.put(parent_of(owner), owner.rpartition("/")[2], node)

    # -- what each kind of model decides

    @abstractmethod
    def _make(self, path: str, kind: type[Node], **given: Any) -> Any:
        """Return a new node for a place, with everything that it needs."""

    @abstractmethod
    def _free_name(self, path: str, wanted: str) -> str:
        """Return a free name at a place, similar to a requested one."""

    @abstractmethod
    def _renamed(self, path: str, before: str, after: str) -> None:
        """Write a new name where others refer to it."""

    @abstractmethod
    def _left(self, owner: str) -> str | None:
        """Return the part to show after a part of an owner was removed."""

    # --

    def _feature_at(self, path: str) -> Feature:
        """Return the feature that holds the node at a path."""
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


def refusals(
    edit: Changes, connect: Callable[[str, str], None], source: str, targets: Iterable[str]
) -> dict[str, str | None]:
    """Return for each end why it does not fit a source, by trying it; None: it fits."""
    return {target: _refusal(edit, connect, source, target) for target in targets if target != source}


def _refusal(edit: Changes, connect: Callable[[str, str], None], source: str, target: str) -> str | None:
    before = edit.model, edit.selected
    try:
        connect(source, target)
    except ExperimentError as error:
        return error.message
    finally:
        edit.model, edit.selected = before
    return None


def _value(feature: Feature, kind: Value, text: str) -> Any:
    try:
        return kind.parse(text)
    except ValueError:
        raise ExperimentError(f"'{feature.name}' cannot be '{text:.60}'; it must be {kind.expects}") from None


def _is_given(feature: Feature, node: Node) -> bool:
    """Whether a node has a value other than its default."""
    default: object = node.__dataclass_fields__[feature.field].default
    return bool(getattr(node, feature.field) != default)


def _holds(feature: Feature, node: Node) -> bool:
    """Whether a node has a value that fits a feature of another class."""
    for own in features(type(node)):
        if own.field == feature.field and own.many == feature.many:
            same = own.of is feature.of or not (isinstance(own.of, Value) or isinstance(feature.of, Value))
            value = getattr(node, own.field)
            fits = isinstance(feature.of, Value) or value is None or isinstance(value, (feature.of, tuple))
            return same and fits
    return False
