"""Values and types of expressions, found without executing code."""

from __future__ import annotations

import ast
import builtins
import dataclasses
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import FunctionType, MethodType, ModuleType
from typing import Any, Final, TypeAlias, cast, get_args, get_origin, get_type_hints

import numpy as np

from nrp_core.dsl.devices import Device, DeviceGroup, ReadOnlyAttribute, SettableAttribute
from nrp_core.dsl.parameters import Adapter, SubscribedTopic
from nrp_core.dsl.selection import BrainRoot, Selection, Selector


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A known value: a constant, a module, a class, or the adapter of a parameter."""

    value: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Known) and (
            self.value is other.value
            or (isinstance(self.value, int | float | str) and self.value == other.value)
        )

    __hash__ = object.__hash__


@dataclass(frozen=True, slots=True)
class Instance:
    """An unknown object of a class; ``item`` is the shape of the items of a list."""

    cls: type
    item: Shape = None


Shape: TypeAlias = Known | Instance | None
"""What is known of a value; None: nothing."""
NUMBER: Final = Instance(float)
UNKNOWN_ATTRIBUTE: Final = object()
"""The value of an attribute of a module that is known only when the module is executed."""
NEURONS: Final = (Selector, BrainRoot, Selection)
"""Placeholders for neurons before a run; attributes, indices and sums of them are placeholders, too."""
PLAIN: Final[Any] = int | float | str | tuple | list | dict | None
"""Constants, which can be compared and printed as when the file is executed."""
_ABSENT: Final = object()
CHECKED_MODULES: Final = ("math", "numpy")
"""Third-party modules whose names are checked."""
DEVICE_UNITS: Final = {
    "voltage": "mV", "rate": "Hz", "frequency": "Hz", "amplitude": "nA", "offset": "nA", "mean": "nA",
    "stdev": "nA", "phase": "deg",
}  # fmt: skip
_OPERATIONS: Final[dict[type, Callable[[Any, Any], Any]]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod, ast.Div: operator.truediv,
}  # fmt: skip
NUMERIC: Final[tuple[Any, ...]] = (float, int, abs, round, len, min, max, sum)
"""Functions whose result is a number if their arguments are."""


def value_of(shape: Shape, kind: Any = object) -> Any:
    """Return a value that is known and of a kind; else None."""
    return shape.value if isinstance(shape, Known) and isinstance(shape.value, kind) else None


def class_of(shape: Shape) -> type | None:
    """Return the class of a value; None if it is unknown."""
    return type(shape.value) if isinstance(shape, Known) else None if shape is None else shape.cls


def is_number(shape: Shape) -> bool:
    """Return whether a value is certainly a number."""
    return issubclass(class_of(shape) or object, int | float)


def adapter_of(shape: Shape) -> Adapter | None:
    """Return the adapter of a parameter, if a value is one."""
    return cast("Adapter | None", value_of(shape, Adapter))


def joined(first: Shape, second: Shape) -> Shape:
    """Return what is known of a value that has one of two shapes."""
    if first == second:
        return first
    return NUMBER if is_number(first) and is_number(second) else None


def item_of(shape: Shape) -> Shape:
    """Return the common shape of the items of a sequence."""
    match shape:
        case Instance(_, item):
            return item
        case Known(DeviceGroup() as group):
            return Known(group[0])
        case Known(list() | tuple() | range() as values) if len(values) < 1000:
            return _common(list(map(Known, values)))
    return None


def _common(items: list[Shape]) -> Shape:
    return items[0] if items and all(one == items[0] for one in items) else None


def is_message(cls: object) -> bool:
    """Return whether something is a class of messages."""
    return isinstance(cls, type) and dataclasses.is_dataclass(cls) and hasattr(cls, "__msgtype__")


# -- attributes


def attribute(owner: Shape, name: str) -> Shape:
    """Return the shape of an attribute."""
    match owner:
        case Known(DeviceGroup() as group):
            found = None if hasattr(type(group), name) else attribute(Known(group[0]), name)
            return None if found is None else Instance(list, found)
        case Known(Adapter() as adapter):
            return _attribute_of_adapter(adapter, name)
        case Known(ModuleType() as module):
            value = _member(module, name)
            return None if value is UNKNOWN_ATTRIBUTE else Known(value)
        case Known(value) if isinstance(value, NEURONS) and not name.startswith("_"):
            return Known(getattr(value, name))
        case Known(str() | dict() as value) if hasattr(value, name):
            return Known(getattr(value, name))
        case Known(type() as cls) if dataclasses.is_dataclass(cls) and hasattr(cls, name):
            return Known(getattr(cls, name))
        case Instance(cls) | Known(object(__class__=cls)) if dataclasses.is_dataclass(cls):
            return _attribute_of_instance(cls, name)
    return None


def has_attribute(owner: Shape, name: str) -> bool:
    """Return whether an object may have an attribute."""
    match owner:
        case None:
            return True
        case Known(DeviceGroup() as group):
            return hasattr(type(group), name) or has_attribute(Known(group[0]), name)
        case Known(Adapter() as adapter):
            return hasattr(type(adapter), name)
        case Known(ModuleType() as module):
            return name.startswith("__") or _member(module, name, _ABSENT) is not _ABSENT
        case Known(type() | FunctionType() | MethodType() as value):
            return hasattr(value, name)
    cls = class_of(owner)
    if cls is float:
        return hasattr(np.float64, name)
    if cls is None or not (dataclasses.is_dataclass(cls) or issubclass(cls, int | float)):
        return True
    fields = getattr(cls, "__dataclass_fields__", ())
    return name in fields or hasattr(cls, name) or hasattr(cls, "__getattr__")


def _attribute_of_adapter(adapter: Adapter, name: str) -> Shape:
    found = getattr(type(adapter), name, None)
    if isinstance(adapter, SubscribedTopic) and name == "value":
        return _instance_of(adapter.info.type)
    if isinstance(found, ReadOnlyAttribute) and name in DEVICE_UNITS:
        return NUMBER
    return Known(getattr(adapter, name)) if isinstance(found, FunctionType) else None


def _attribute_of_instance(cls: type, name: str) -> Shape:
    if name in hints(cls):
        return shape_of_hint(hints(cls)[name])
    found = getattr(cls, name, None)
    return shape_of_hint(hints(found.fget).get("return")) if isinstance(found, property) else None


def _member(module: ModuleType, name: str, default: Any = UNKNOWN_ATTRIBUTE) -> Any:
    try:
        return getattr(module, name)
    except (AttributeError, ImportError):
        return default


def names_of(shape: Shape) -> list[str]:
    """Return the public attributes of an object."""
    match shape:
        case Known(DeviceGroup() as group):
            return names_of(Known(group[0]))
        case Known(Device() as device):
            own = set(dir(type(device))) - set(dir(Device))
            methods = sorted(one for one in own if callable(getattr(type(device), one)))
            return [*device.attributes(), *(one for one in methods if not one.startswith("_"))]
        case Known(ModuleType() as module):
            return [name for name in dir(module) if not name.startswith("_")]
        case Known(Adapter() as adapter):
            return sorted(one for one in set(dir(type(adapter))) - set(dir(Adapter)) if one[0] != "_")
    cls = class_of(shape)
    if cls is None or not dataclasses.is_dataclass(cls):
        return []
    properties = [name for name in dir(cls) if isinstance(getattr(cls, name), property)]
    return [*(one.name for one in dataclasses.fields(cls)), *properties]


def can_set(adapter: Adapter, name: str) -> bool:
    """Return whether an attribute exists and can be set."""
    owner = adapter[0] if isinstance(adapter, DeviceGroup) else adapter
    found = getattr(type(owner), name)
    if isinstance(found, ReadOnlyAttribute):
        return isinstance(found, SettableAttribute)
    if isinstance(found, property):
        return found.fset is not None
    return not isinstance(owner, SubscribedTopic) and not isinstance(found, FunctionType | MethodType)


def _instance_of(cls: Any) -> Shape:
    return Instance(cls) if isinstance(cls, type) and dataclasses.is_dataclass(cls) else None


def shape_of_hint(hint: Any) -> Shape:
    """Return the shape of a value by its declared type."""
    if get_origin(hint) is list and get_args(hint):
        return Instance(list, shape_of_hint(get_args(hint)[0]))
    return NUMBER if hint in (int, float) else _instance_of(hint)


@cache
def hints(owner: Any) -> dict[str, Any]:
    """Return the declared types of a class or function; empty if they cannot be determined."""
    try:
        return get_type_hints(owner)
    except (NameError, TypeError):
        return {}


# -- expressions


class Expressions:
    """Derives the shapes of expressions from those of names.

    Args:
        names: the shape of each name.

    Attributes:
        divide: the operator ``/``.
    """

    divide: Callable[[Any, Any], Any] = staticmethod(operator.truediv)

    def __init__(self, names: Mapping[str, Shape]) -> None:
        self.names = dict(names)

    def name(self, name: str) -> Shape:
        """Return the shape of a name."""
        if name in self.names:
            return self.names[name]
        return Known(getattr(builtins, name)) if hasattr(builtins, name) else None

    def shape(self, node: ast.AST | None) -> Shape:
        """Return the shape of an expression."""
        match node:
            case ast.Constant(value):
                return Known(value)
            case ast.Name(name):
                return self.name(name)
            case ast.Attribute(value, name):
                return attribute(self.shape(value), name)
            case ast.Subscript(value, index):
                return self.item(node, self.shape(value), self.shape(index))
            case ast.Slice(lower, upper, step):
                parts = [Known(None) if one is None else self.shape(one) for one in (lower, upper, step)]
                return Known(slice(*known)) if (known := values_of(parts)) is not None else None
            case ast.Tuple(items) | ast.List(items):
                return _sequence(type(node), [self.shape(one) for one in items])
            case ast.ListComp(element):
                return Instance(list, self.shape(element))
            case ast.JoinedStr(parts):
                texts = values_of(list(map(self.shape, parts)))
                is_plain = texts is not None and all(isinstance(one, PLAIN) for one in texts)
                return Known("".join(map(str, texts or ()))) if is_plain else Instance(str)
            case ast.Call():
                return self.call(node)
        return self._computed(node)

    def _computed(self, node: ast.AST | None) -> Shape:
        """Return the shape of the result of an operator."""
        match node:
            case ast.BinOp(left, operation, right):
                return self._operation(operation, self.shape(left), self.shape(right))
            case ast.UnaryOp(ast.USub(), operand):
                found = self.shape(operand)
                value = value_of(found, int | float)
                return (found if is_number(found) else None) if value is None else Known(-value)
            case ast.Compare(left, operations, others):
                shapes = [self.shape(one) for one in (left, *others)]
                match shapes, operations:
                    case [Known(one), Known(other)], [ast.Eq() | ast.NotEq() as order]:
                        if isinstance(one, PLAIN) and isinstance(other, PLAIN):
                            return Known((one == other) is isinstance(order, ast.Eq))
                return Instance(bool) if all(map(is_number, shapes)) else None
            case ast.UnaryOp(ast.Not()):
                return Instance(bool)
            case ast.FormattedValue(value, format_spec=None):
                return self.shape(value)
            case ast.IfExp(_, body, orelse):
                return joined(self.shape(body), self.shape(orelse))
        return None

    def item(self, node: ast.Subscript, owner: Shape, index: Shape) -> Shape:
        """Return the shape of an item of a sequence."""
        match owner, index:
            case Known(value), Known(key) if isinstance(value, NEURONS):
                return Known(value[key])
            case Known(list() | tuple() | str() | dict() | range()), Known(key):
                try:
                    return Known(owner.value[key])
                except (LookupError, TypeError):
                    return None
        if isinstance(node.slice, ast.Slice) or value_of(index, slice) is not None:
            return owner if isinstance(owner, Instance) else None
        return item_of(owner)

    def _operation(self, operation: ast.operator, left: Shape, right: Shape) -> Shape:
        work = self.divide if isinstance(operation, ast.Div) else _OPERATIONS.get(type(operation))
        match left, right:
            case Known(one), Known(other) if work is not None and _is_combined(operation, one, other):
                try:
                    return Known(work(one, other))
                except (ArithmeticError, TypeError, ValueError):
                    return None
        return NUMBER if is_number(left) and is_number(right) else None

    def call(self, node: ast.Call) -> Shape:
        """Return the shape of the result of a call."""
        called = value_of(self.shape(node.func))
        if isinstance(called, type) and dataclasses.is_dataclass(called):
            return Instance(called)
        if any(called is one for one in NUMERIC):
            return self._number_of(called, [self.shape(one) for one in node.args])
        if str(getattr(called, "__module__", "")).startswith("nrp_core."):
            return shape_of_hint(hints(called).get("return"))
        return None

    @staticmethod
    def _number_of(function: Any, given: list[Shape]) -> Shape:
        match given:
            case [Known(str() as text)] if function is float:
                try:
                    return Known(float(text))  # "nan", "inf"
                except ValueError:
                    return None
            case [one] if one is not None and function in (min, max, sum) and not is_number(one):
                return NUMBER if is_number(item_of(one)) else None
        return NUMBER if function in (int, len) or (given and all(map(is_number, given))) else None


def values_of(shapes: list[Shape]) -> list[Any] | None:
    """Return the values of shapes; None if one of them is unknown."""
    known = [one.value for one in shapes if isinstance(one, Known)]
    return known if len(known) == len(shapes) else None


def _sequence(kind: type[ast.expr], items: list[Shape]) -> Shape:
    made = tuple if kind is ast.Tuple else list
    known = values_of(items)
    if known is not None and not any(isinstance(one, Adapter) for one in known):
        return Known(made(known))
    return Instance(made, _common(items))


def _is_combined(operation: ast.operator, left: Any, right: Any) -> bool:
    """Return whether an operation on two values has a small result and no other effect."""
    if isinstance(left, NEURONS) or isinstance(right, NEURONS):
        return True
    if isinstance(left, str):
        return isinstance(operation, ast.Add) and isinstance(right, str)
    return isinstance(left, int | float) and isinstance(right, int | float)
