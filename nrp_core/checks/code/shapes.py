"""What is known of a value without executing code, and the operations on it in a function's body."""

from __future__ import annotations

import ast
import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import FunctionType, MethodType, ModuleType
from typing import Any, TypeAlias, get_args, get_origin, get_type_hints

import numpy as np

from nrp_core.dsl.devices import Device, DeviceGroup, ReadOnlyAttribute, SettableAttribute
from nrp_core.dsl.parameters import Adapter, SubscribedTopic
from nrp_core.dsl.selection import BrainRoot, Selection, Selector
from nrp_core.errors import Instead, did_you_mean


@dataclass(frozen=True, slots=True)
class Unknown:
    """Nothing is known."""


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A known value: a constant, a module, a class, or the adapter of a parameter."""

    value: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Known) and (
            self.value is other.value
            or (isinstance(self.value, (int, float, str)) and self.value == other.value)
        )

    def __hash__(self) -> int:
        return id(self.value)


@dataclass(frozen=True, slots=True)
class Instance:
    """An object of a class."""

    cls: type


@dataclass(frozen=True, slots=True)
class Number:
    """A number in a unit; an empty unit is unknown."""

    unit: str


@dataclass(frozen=True, slots=True)
class Items:
    """A sequence whose items have the same shape."""

    item: Shape


@dataclass(frozen=True, slots=True)
class Row:
    """A tuple or list with a shape for each item."""

    items: tuple[Shape, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Names:
    """A module that is read and not executed."""

    module: str
    names: Mapping[str, Shape]


Shape: TypeAlias = Unknown | Known | Instance | Number | Items | Row | Names

UNKNOWN = Unknown()

NEURONS = (Selector, BrainRoot, Selection)
"""A placeholder for neurons before a run; attributes, indices and sums of it are placeholders, too."""

UNITS = {
    "voltage": "mV", "rate": "Hz", "frequency": "Hz", "amplitude": "nA", "offset": "nA", "mean": "nA",
    "stdev": "nA", "phase": "deg",
}  # fmt: skip
"""Units of the attributes of devices."""
MODULES = ("math", "numpy")
"""Third-party modules whose names are checked."""


def joined(first: Shape, second: Shape) -> Shape:
    """Return the common shape of a value that has one of two shapes."""
    return first if first == second else UNKNOWN


def item_of(shape: Shape) -> Shape:
    """Return the common shape of the items of a sequence."""
    match shape:
        case Items(item):
            return item
        case Row(items) if items:
            first = items[0]
            return first if all(item == first for item in items) else UNKNOWN
        case Known(DeviceGroup() as group):
            return Known(group[0])
    return UNKNOWN


def attribute(shape: Shape, name: str) -> Shape | None:
    """Return the shape of an attribute; None if there is no such attribute."""
    match shape:
        case Known(DeviceGroup() as group):
            own = getattr(type(group), name, None)
            return UNKNOWN if own is not None else _of_all(group[0], name)
        case Known(Adapter() as adapter):
            return _of_adapter(adapter, name)
        case Known(ModuleType() as module):
            return _of_module(module, name)
        case Names(_, names):
            return UNKNOWN if name.startswith("__") else names.get(name)
        case Known(value) if isinstance(value, NEURONS) and not name.startswith("_"):
            return Known(getattr(value, name))
        case Known(type() as cls) if dataclasses.is_dataclass(cls):
            return Known(getattr(cls, name)) if hasattr(cls, name) else None
        case Instance(cls):
            return _of_instance(cls, name)
        case Number():  # some are NumPy functions
            return UNKNOWN if hasattr(np.float64, name) else None
    return UNKNOWN


def _of_all(device: Device, name: str) -> Shape | None:
    found = _of_adapter(device, name)
    return None if found is None else Items(found)


def _of_adapter(adapter: Adapter, name: str) -> Shape | None:
    if not hasattr(type(adapter), name):
        return None
    if isinstance(adapter, SubscribedTopic) and name == "value":
        return instance_of(adapter.info.type)
    if isinstance(getattr(type(adapter), name), ReadOnlyAttribute) and name in UNITS:
        return Number(UNITS[name])
    if isinstance(getattr(type(adapter), name), FunctionType):
        return Known(getattr(adapter, name))
    return UNKNOWN


def _of_module(module: ModuleType, name: str) -> Shape | None:
    if name in vars(module):
        return Known(vars(module)[name])
    if hasattr(module, "__getattr__") or module.__name__ in MODULES:
        try:
            return Known(getattr(module, name))
        except (AttributeError, ImportError):
            return None
    return None


def _of_instance(cls: type, name: str) -> Shape | None:
    if name in hints(cls):
        return of_hint(hints(cls)[name])
    if not hasattr(cls, name):
        return UNKNOWN if hasattr(cls, "__getattr__") else None
    found = getattr(cls, name)
    if isinstance(found, property) and found.fget is not None:
        return of_hint(hints(found.fget).get("return"))
    return UNKNOWN


def instance_of(cls: Any) -> Shape:
    """Return the shape of the instances of a class; unknown for most classes."""
    return Instance(cls) if isinstance(cls, type) and dataclasses.is_dataclass(cls) else UNKNOWN


def of_hint(hint: Any) -> Shape:
    """Return the shape of a value by its declared type."""
    if get_origin(hint) is list and get_args(hint):
        return Items(of_hint(get_args(hint)[0]))
    return Number("") if hint in (int, float) else instance_of(hint)


@cache
def hints(owner: Any) -> dict[str, Any]:
    """Return the declared types of a class or function; empty if they cannot be determined."""
    try:
        return get_type_hints(owner)
    except (NameError, TypeError):
        return {}


def names_of(shape: Shape) -> list[str]:
    """Return the public attributes of an object."""
    match shape:
        case Known(DeviceGroup() as group):
            return names_of(Known(group[0]))
        case Known(Device() as device):
            return [*device.attributes(), *_methods(type(device))]
        case Known(ModuleType() as module):
            return [name for name in dir(module) if not name.startswith("_")]
        case Names(_, names):
            return list(names)
        case Known(Adapter() as adapter):
            own = set(dir(type(adapter))) - set(dir(Adapter))
            return sorted(name for name in own if not name.startswith("_"))
        case Instance(cls):
            fields = [field.name for field in dataclasses.fields(cls)]
            properties = [name for name in dir(cls) if isinstance(getattr(cls, name), property)]
            return [*fields, *properties]
    return []


def _methods(kind: type[Device]) -> list[str]:
    """Return the methods that a kind of device adds to the base class."""
    own = set(dir(kind)) - set(dir(Device)) - set(kind.attributes())
    return sorted(name for name in own if not name.startswith("_") and callable(getattr(kind, name)))


def can_set(adapter: Adapter, name: str) -> bool:
    """Return whether an attribute exists and can be set."""
    owner = adapter[0] if isinstance(adapter, DeviceGroup) else adapter
    found = getattr(type(owner), name)
    if isinstance(found, ReadOnlyAttribute):
        return isinstance(found, SettableAttribute)
    if isinstance(found, property):
        return found.fset is not None
    if isinstance(owner, SubscribedTopic):
        return False
    return not isinstance(found, (FunctionType, MethodType))


@dataclass(frozen=True, slots=True)
class Read:
    """An attribute is read."""

    node: ast.Attribute
    owner: Shape
    name: str
    exists: bool


@dataclass(frozen=True, slots=True)
class Write:
    """An attribute is set; ``exists``: whether the object has it."""

    node: ast.Attribute
    owner: Shape
    name: str
    exists: bool
    value: Shape


@dataclass(frozen=True, slots=True)
class Call:
    """An object is called; ``is_whole``: whether all its arguments are known."""

    node: ast.Call
    callee: Shape
    given: tuple[Shape, ...]
    named: Mapping[str, Shape]
    is_whole: bool


@dataclass(frozen=True, slots=True)
class Divide:
    """A division or modulo operation."""

    node: ast.BinOp
    left: Shape
    right: Shape


@dataclass(frozen=True, slots=True)
class Add:
    """An addition, subtraction or comparison."""

    node: ast.expr
    left: Shape
    right: Shape


@dataclass(frozen=True, slots=True)
class Multiply:
    """A multiplication."""

    node: ast.BinOp
    left: Shape
    right: Shape


@dataclass(frozen=True, slots=True)
class Compute:
    """An operand of a computation or an order comparison."""

    node: ast.expr
    operand: Shape


@dataclass(frozen=True, slots=True)
class Index:
    """An item is read; ``index`` is None in a loop over all items."""

    node: ast.expr
    owner: Shape
    index: Shape | None


@dataclass(frozen=True, slots=True)
class Rename:
    """A parameter's name is assigned another value, so that its device or topic cannot be used any more."""

    node: ast.Name
    owner: Shape


@dataclass(frozen=True, slots=True)
class Return:
    """The function returns; ``value`` is None for a bare return."""

    node: ast.Return
    value: Shape | None


Event: TypeAlias = Read | Write | Call | Divide | Add | Multiply | Compute | Index | Rename | Return


def missing_name(event: Read) -> tuple[str, Instead | None]:
    """Return the message for a name that a module does not have, and what to replace it with."""
    hint = did_you_mean(event.name, names_of(event.owner))
    return f"'{ast.unparse(event.node.value)}' has no '{event.name}'{hint}", hint.instead


@dataclass(frozen=True, slots=True)
class Imported:
    """A name that an import binds.

    Args:
        name: the name.
        shape: its shape.
        wrong: why the import fails; empty if it does not.
    """

    name: str
    shape: Shape = UNKNOWN
    wrong: str = ""


ImportsOf: TypeAlias = Callable[[ast.Import | ast.ImportFrom, Path], Iterable[Imported]]
"""Returns the names that a statement in a file imports."""


def full_names(tree: ast.Module) -> dict[str, str]:
    """Return the full names of imported modules and of the names imported from them."""
    found: dict[str, str] = {}
    for node in ast.walk(tree):
        match node:
            case ast.Import(names):
                found |= {alias.asname or alias.name: alias.name for alias in names}
            case ast.ImportFrom(module=str(module), names=names, level=0):
                found |= {alias.asname or alias.name: f"{module}.{alias.name}" for alias in names}
    return found
