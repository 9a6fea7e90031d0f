"""Find code that relies on the platform's names and libraries.

Static analysis cannot be certain, so code that may differ counts as different.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from nrp_legacy.files import Library
from nrp_legacy.python2 import may_be_whole
from nrp_legacy.shims.libraries import libraries_of_old
from nrp_legacy.shims.paths import Paths

_GIVEN = {"np": "numpy", "numpy": "numpy", "cv2": "cv2", "sys": "sys"}
"""Modules that code finds without an import."""
_OPENING = frozenset({"open", "file"})
_ARRAYS = frozenset({"position", "velocity", "effort", "ranges", "intensities", "data", "covariance"})
"""Fields of messages with many numbers: tuples on the platform, arrays here."""
_OF_TUPLES = frozenset({"index", "count"})
_LISTS = frozenset({"map", "filter", "zip", "range", "keys", "values", "items"})
"""Functions and methods that gave lists in Python 2."""
_TAKING = frozenset(
    {"list", "tuple", "sorted", "set", "dict", "sum", "min", "max", "any", "all", "enumerate", "len", "array",
     "zip", "map", "filter", "map_neurons", "OrderedDict", "deque", "join", "reversed", "asarray", "mean"}
)  # fmt: skip
"""Functions to which it does not matter whether they get a list."""
_SIZES = frozenset({"range", "xrange", "zeros", "ones", "empty", "full", "reshape", "resize", "linspace"})
"""Functions that take whole numbers only."""


def reliance(tree: ast.Module) -> str:
    """Return the platform feature that code relies on, empty for none."""
    found = (*_old_libraries(tree), *_whole_quotients(tree), *_tuples(tree), *_lists(tree))
    return next(iter(found), "")


# -- libraries


def _old_libraries(tree: ast.Module) -> Iterator[str]:
    """Yield uses of library parts that differ from today's, or that are seeded on the platform."""
    old = libraries_of_old({}, lambda _seconds: None, 0, [], Paths(Library(Path())))
    modules = dict(_GIVEN)
    for module, name, bound in _imports(tree):
        yield from _differing(old, module, [name] if name else [])
        if not name:
            modules[bound or module.partition(".")[0]] = module if bound else module.partition(".")[0]
        elif f"{module}.{name}" in old:
            modules[bound or name] = f"{module}.{name}"
    beside = _of_files_beside(tree)
    for node in ast.walk(tree):
        root, parts = _chain(node)
        if root in modules and node not in beside:
            yield from _differing(old, modules[root], parts)
        elif isinstance(node, ast.Name) and node.id in _OPENING and node not in beside:
            yield f"{node.id}() with files outside the experiment"


def _imports(tree: ast.Module) -> Iterator[tuple[str, str, str | None]]:
    """Yield imports: the module, the imported name (empty: the module itself), and the local name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "", alias.asname) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield from ((node.module, alias.name, alias.asname) for alias in node.names)


def _of_files_beside(tree: ast.Module) -> set[ast.expr]:
    """Return the functions that are called with a path from the folder of the code."""
    names = {"__file__"}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and _mentions(node.value, names):
            names |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call))
    return {call.func for call in calls if any(_mentions(value, names) for value in call.args)}


def _mentions(value: ast.expr, names: set[str]) -> bool:
    return any(isinstance(node, ast.Name) and node.id in names for node in ast.walk(value))


def _chain(node: ast.AST) -> tuple[str, list[str]]:
    """Return the name at the start of a chain of attributes, and the attributes."""
    parts: list[str] = []
    while isinstance(node, ast.Attribute):
        parts.insert(0, node.attr)
        node = node.value
    return (node.id if isinstance(node, ast.Name) and parts else ""), parts


def _differing(old: dict[str, ModuleType], name: str, parts: list[str]) -> Iterator[str]:
    """Yield the dotted name of a function that differs from the platform's."""
    there: Any = old.get(name)
    if there is None:
        return
    here: Any = _module_here(name)
    if here is None:
        yield name
        return
    for i, part in enumerate(parts):
        there, here = getattr(there, part, None), getattr(here, part, None)
        if there is here:
            return
        if not isinstance(there, ModuleType) or not isinstance(here, ModuleType):
            yield ".".join([name, *parts[: i + 1]])
            return


def _module_here(name: str) -> ModuleType | None:
    try:
        return import_module(name)
    except ImportError:
        return None


# -- numbers


def _whole_quotients(tree: ast.Module) -> Iterator[str]:
    """Yield divisions whose result must be a whole number, as in Python 2."""
    names = {
        target.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and _divides(node.value, frozenset())
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Subscript):
            places = [node.slice]
        elif isinstance(node, ast.Call) and _called(node) in _SIZES:
            places = node.args
        else:
            continue
        if any(_divides(place, frozenset(names)) for place in places):
            yield f"a quotient as a whole number, line {node.lineno}"


def _divides(place: ast.expr, names: frozenset[str]) -> bool:
    """Return whether an expression contains a quotient that may be whole, outside ``int()`` and the like."""
    if isinstance(place, ast.Call) and _called(place) in ("int", "round", "float", "len"):
        return False
    if isinstance(place, ast.BinOp) and may_be_whole(place):
        return True
    if isinstance(place, ast.Name):
        return place.id in names
    return any(_divides(one, names) for one in ast.iter_child_nodes(place) if isinstance(one, ast.expr))


def _called(node: ast.Call) -> str:
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


# -- messages


def _tuples(tree: ast.Module) -> Iterator[str]:
    """Yield uses of message fields as the tuples that they are on the platform."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in _OF_TUPLES and _is_array(node.value):
            yield f"{ast.unparse(node)}, of a tuple"
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            sides = (node.left, node.right)
            if any(map(_is_array, sides)) and any(isinstance(side, (ast.Tuple, ast.List)) for side in sides):
                yield f"{ast.unparse(node)}, of tuples"


def _is_array(node: ast.expr) -> bool:
    return isinstance(node, ast.Attribute) and node.attr in _ARRAYS


# -- lists


def _lists(tree: ast.Module) -> Iterator[str]:
    """Yield values that are used as a list but are not one in Python 3."""
    iterated: set[ast.expr] = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.For, ast.comprehension)):
            iterated.add(node.iter)
        elif isinstance(node, ast.Call) and _called(node) in _TAKING:
            iterated.update(node.args)
        elif isinstance(node, ast.Compare):
            iterated.update(node.comparators)
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _called(node) in _LISTS and node not in iterated:
            yield f"{_called(node)}() as a list, line {node.lineno}"
