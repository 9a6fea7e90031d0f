"""Transfer functions of the platform as files of ours: the same code, with other imports and spellings.

Code that uses the platform's names and libraries does not change.
"""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from nrp_core import dsl
from nrp_core.dsl import DeviceKind, file_names
from nrp_legacy.code import Source, defined, ignore_note, without_deprecation_warnings
from nrp_legacy.files import Library
from nrp_legacy.framework import SPELLINGS
from nrp_legacy.python2 import DIVIDE, ROUND, converted, is_integer_division, rewritten
from nrp_legacy.shims.graph import absolute
from nrp_legacy.shims.libraries import old_libraries
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


Use = tuple[str, int]
"""A feature of the platform that code relies on, and the line."""


def reliance(tree: ast.Module) -> Use:
    """Return the first use of a platform feature that code relies on, empty for none."""
    found = (*_old_libraries(tree), *_whole_quotients(tree), *_tuples(tree), *_lists(tree))
    return next(iter(found), ("", 0))


# -- libraries


def _old_libraries(tree: ast.Module) -> Iterator[Use]:
    """Yield uses of library parts that differ from today's, or that are seeded on the platform."""
    old = old_libraries({}, lambda _seconds: None, 0, [], Paths(Library(Path())))
    modules = dict(_GIVEN)
    for line, module, name, bound in _imports(tree):
        yield from _differing(old, module, [name] if name else [], line)
        if not name:
            modules[bound or module.partition(".")[0]] = module if bound else module.partition(".")[0]
        elif f"{module}.{name}" in old:
            modules[bound or name] = f"{module}.{name}"
    beside = _of_files_beside(tree)
    for node in ast.walk(tree):
        root, parts = _chain(node)
        if root in modules and node not in beside:
            yield from _differing(old, modules[root], parts, node.lineno)  # type: ignore[attr-defined]
        elif isinstance(node, ast.Name) and node.id in _OPENING and node not in beside:
            yield f"{node.id}() with files outside the experiment", node.lineno


def _imports(tree: ast.Module) -> Iterator[tuple[int, str, str, str | None]]:
    """Yield imports: line, module, imported name (empty: the module itself), and local name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name, "", alias.asname) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield from ((node.lineno, node.module, alias.name, alias.asname) for alias in node.names)


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


def _differing(old: dict[str, ModuleType], name: str, parts: list[str], line: int) -> Iterator[Use]:
    """Yield the dotted name of a function that differs from the platform's."""
    there: Any = old.get(name)
    if there is None:
        return
    here: Any = _module_here(name)
    if here is None:
        yield name, line
        return
    for i, part in enumerate(parts):
        there, here = getattr(there, part, None), getattr(here, part, None)
        if here is there or here is getattr(there, "__wrapped__", there):
            return
        if not isinstance(there, ModuleType) or not isinstance(here, ModuleType):
            yield ".".join([name, *parts[: i + 1]]), line
            return


def _module_here(name: str) -> ModuleType | None:
    try:
        return import_module(name)
    except ImportError:
        return None


# -- numbers


def _whole_quotients(tree: ast.Module) -> Iterator[Use]:
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
            yield "a quotient as a whole number", node.lineno


def _divides(place: ast.expr, names: frozenset[str]) -> bool:
    """Return whether an expression contains a quotient that may be whole, outside ``int()`` and the like."""
    if isinstance(place, ast.Call) and _called(place) in ("int", "round", "float", "len"):
        return False
    if isinstance(place, ast.BinOp) and is_integer_division(place):
        return True
    if isinstance(place, ast.Name):
        return place.id in names
    return any(_divides(one, names) for one in ast.iter_child_nodes(place) if isinstance(one, ast.expr))


def _called(node: ast.Call) -> str:
    return node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


# -- messages


def _tuples(tree: ast.Module) -> Iterator[Use]:
    """Yield uses of message fields as the tuples that they are on the platform."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in _OF_TUPLES and _is_array(node.value):
            yield f"{ast.unparse(node)}, of a tuple", node.lineno
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            sides = (node.left, node.right)
            if any(map(_is_array, sides)) and any(isinstance(side, (ast.Tuple, ast.List)) for side in sides):
                yield f"{ast.unparse(node)}, of tuples", node.lineno


def _is_array(node: ast.expr) -> bool:
    return isinstance(node, ast.Attribute) and node.attr in _ARRAYS


# -- lists


def _lists(tree: ast.Module) -> Iterator[Use]:
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
            yield f"{_called(node)}() as a list", node.lineno


@dataclass
class Edits:
    """Replacements in a text.

    Args:
        text: the program.
    """

    text: str
    _made: list[tuple[int, int, str]] = field(default_factory=list)

    def replace(self, node: ast.AST, new: str) -> None:
        """Replace a node by a text; nodes inside a replaced node are ignored."""
        begin, end = self._span(node)
        if any(a <= begin and end <= b for a, b, _ in self._made):
            return
        self._made = [one for one in self._made if not (begin <= one[0] and one[1] <= end)]
        self._made.append((begin, end, new))

    def drop_argument(self, node: ast.keyword) -> None:
        """Remove an argument of a call, with the comma before it."""
        begin, end = self._span(node)
        comma = self.text.rfind(",", 0, begin)
        self._made.append((comma, end, ""))

    def rename_argument(self, node: ast.keyword, name: str) -> None:
        """Rename a keyword argument of a call."""
        begin, _ = self._span(node)
        self._made.append((begin, begin + len(node.arg or ""), name))

    def done(self) -> str:
        """Return the text with all changes."""
        text = self.text
        for begin, end, new in sorted(self._made, reverse=True):
            text = text[:begin] + new + text[end:]
        return text

    def _span(self, node: ast.AST) -> tuple[int, int]:
        lines = [f"{line}\n" for line in self.text.split("\n")]

        def at(line: int, column: int) -> int:
            before = lines[line - 1].encode()[:column].decode()
            return sum(map(len, lines[: line - 1])) + len(before)

        return at(node.lineno, node.col_offset), at(node.end_lineno, node.end_col_offset)  # type: ignore[attr-defined]


FRAMEWORKS = ("hbp_nrp_cle.tf_framework", "python_cle.tf_framework")
_PACKAGES = ("hbp_nrp_cle", "python_cle")
_NOT_HERE = (
    "rospy", "smach", "smach_ros", "hbp_nrp_excontrol", "tf", "nest", "dynamic_reconfigure",
    "multiprocessing", "threading", "thread",
)  # fmt: skip
_LOGS = "hbp_nrp_excontrol.logs"
_DEVICES = ("MapSpikeSink", "MapSpikeSource")
_TOPICS = ("MapRobotSubscriber", "MapRobotPublisher")
_QUEUES = ("queue_size", "buff_size")

GIVEN = {
    "np": "import numpy as np",
    "numpy": "import numpy",
    "cv2": "import cv2",
    "sys": "import sys",
    "logging": "import logging",
    "logger": "import logging\n\nlogger = logging.getLogger(__name__)",
    "clientLogger": "import logging\n\nclientLogger = logging.getLogger(__name__)\n"
    "clientLogger.advertise = clientLogger.info",
    "CvBridge": "from cv_bridge import CvBridge",
    "reduce": "from functools import reduce",
    "xrange": "xrange = range",
    "unicode": "unicode = str",
    "basestring": "basestring = str",
    "long": "long = int",
    "Topic": "",
    DIVIDE: f"def {DIVIDE}(a, b):\n    return a // b if isinstance(a, int) and isinstance(b, int) else a / b",
    ROUND: f"from decimal import ROUND_HALF_UP, Decimal\n\n\ndef {ROUND}(number, ndigits=0):\n"
    "    unit = Decimal(1).scaleb(-ndigits)\n"
    "    return float((Decimal(float(number)) / unit).to_integral_value(ROUND_HALF_UP) * unit)",
    **dict.fromkeys(("Point", "Pose", "Quaternion"), "from geometry_msgs.msg import {name}"),
    **dict.fromkeys(("Float32", "Int32", "String"), "from std_msgs.msg import {name}"),
}
"""The definitions of names that the platform gave to every transfer function."""


@dataclass(frozen=True)
class Piece:
    """A transfer function file of ours.

    Args:
        text: the code.
        changes: the differences from the original.
        obstacle: the feature of the platform that it needs, empty for none; then it keeps its imports.
        defines: the names at its top level.
        lacks: the undefined names that it uses.
    """

    text: str
    changes: tuple[str, ...]
    obstacle: str
    defines: frozenset[str]
    lacks: frozenset[str]


def piece_of(source: Source, *, obstacle: str = "") -> Piece:
    """Return code as a file of ours.

    Args:
        source: the code.
        obstacle: a feature of the platform that it needs.

    Raises:
        TransferFunctionError: it is not Python.
    """
    text, changes = modern(source)
    with without_deprecation_warnings():
        tree = ast.parse(text)
    place = Place(source, text)
    relied, at = reliance(tree)
    work = _Work(text, obstacle or (f"relies on {relied}{place.of(at)}" if relied else ""), place)
    work.visit(tree)
    defines = frozenset(defined(tree))
    if work.obstacle:
        return Piece(text, changes, work.obstacle, defines, frozenset(_lacking(tree)))
    text = work.edits.done()
    lacks = _lacking(ast.parse(text))
    prelude = [line for name in sorted(lacks) if (line := _prelude(name))]
    lacks -= {name for name in lacks if name in GIVEN or _is_framework(name)}
    if prelude:
        head = "\n".join(sorted(prelude, key=lambda line: not line.startswith(("import", "from"))))
        text = f"{head}\n\n\n{text.lstrip()}"
    return Piece(text, (*changes, *dict.fromkeys(work.changes)), "", defines, frozenset(lacks))


def modern(source: Source) -> tuple[str, tuple[str, ...]]:
    """Return code as Python 3, and the changes.

    Raises:
        TransferFunctionError: it is not Python.
    """
    source.tree(ignore_note)  # reported by its own error
    with without_deprecation_warnings():
        result = converted(source.text)
    text = source.text.rstrip() + "\n"
    if not result.changes:
        return text, ()
    text = rewritten(source.text).rstrip() + "\n"
    names = {node.id for node in ast.walk(result.tree) if isinstance(node, ast.Name)}
    if names & {DIVIDE, ROUND} or _outdated(text):
        text = ast.unparse(result.tree) + "\n"
    return text, (f"leftovers of Python 2: {', '.join(result.changes)}",)


def _outdated(text: str) -> bool:
    """Whether code calls methods that only Python 2 has."""
    with without_deprecation_warnings():
        return bool(converted(text).changes)


@dataclass(frozen=True, slots=True)
class Place:
    """The lines of code in its file.

    Args:
        source: the code.
        text: the same as Python 3.
    """

    source: Source
    text: str

    def of(self, line: int) -> str:
        """Return the file and line of a line of the text, empty if the text has other lines."""
        if self.text.rstrip().count("\n") != self.source.text.rstrip().count("\n"):
            return ""
        return f" ({self.source.path.name}:{line + self.source.first_line - 1})"


class _Work(ast.NodeVisitor):
    def __init__(self, text: str, obstacle: str, place: Place) -> None:
        self.edits, self._place = Edits(text), place
        self.changes: list[str] = []
        self.obstacle = obstacle

    def visit_Import(self, node: ast.Import) -> None:
        new: list[str] = []
        for alias in node.names:
            if alias.name in FRAMEWORKS:
                new += [f"{alias.asname} = nrp"] if alias.asname not in (None, "nrp") else []
            elif alias.name.partition(".")[0] not in _PACKAGES:
                self._check(alias.name, node)
                new.append(f"import {alias.name}" + (f" as {alias.asname}" if alias.asname else ""))
        self._imports(node, new)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        module = node.module or ""
        if module == _LOGS:
            self._imports(node, [])
        elif module.partition(".")[0] not in _PACKAGES:
            self._check(module, node)
        elif module.endswith(".tf_lib"):
            self._imports(node, [_taken(alias, "nrp.tf_lib") for alias in node.names if alias.name != "*"])
        else:
            kept = [alias for alias in node.names if alias.name not in ("*", "Topic", "tf_framework")]
            self._imports(node, [_taken(alias, "nrp") for alias in kept])

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if ast.unparse(node) in FRAMEWORKS:
            self.edits.replace(node, "nrp")
        self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> None:
        if node.id == "rospy":
            self.obstacle = self.obstacle or f"uses rospy{self._place.of(node.lineno)}"

    def visit_Call(self, node: ast.Call) -> None:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in _DEVICES:
            self._device(node)
        elif name in _TOPICS:
            for keyword in node.keywords:
                if keyword.arg in _QUEUES:
                    self.edits.drop_argument(keyword)
        elif name == "Topic" and node.args and isinstance(node.args[0], ast.Constant):
            topic = str(node.args[0].value)
            if topic != absolute(topic).rstrip("/"):
                self.edits.replace(node.args[0], repr(absolute(topic).rstrip("/")))
        self.generic_visit(node)

    def _device(self, node: ast.Call) -> None:
        kind = node.args[2] if len(node.args) > 2 else None
        named = getattr(kind, "attr", getattr(kind, "id", ""))
        options = getattr(dsl, named, None)
        for keyword in node.keywords:
            name = SPELLINGS.get(keyword.arg or "", keyword.arg or "")
            if not isinstance(options, DeviceKind) or keyword.arg is None:
                continue
            if name not in options.options or ast.unparse(keyword.value) == "None":
                self.edits.drop_argument(keyword)
                if ast.unparse(keyword.value) != "None":
                    self.changes.append(f"{named} does not have the setting '{keyword.arg}': left out")
            elif name != keyword.arg:
                self.edits.rename_argument(keyword, name)

    def _imports(self, node: ast.AST, new: list[str]) -> None:
        indent = " " * getattr(node, "col_offset", 0)
        self.edits.replace(node, f"\n{indent}".join(new) if new or not indent else "pass")

    def _check(self, module: str, node: ast.stmt) -> None:
        if module.partition(".")[0] in _NOT_HERE:
            self.obstacle = self.obstacle or f"imports {module}{self._place.of(node.lineno)}"


def _taken(alias: ast.alias, place: str) -> str:
    return f"{alias.asname or alias.name} = {place}.{alias.name}"


def _prelude(name: str) -> str:
    if name in GIVEN:
        return GIVEN[name].format(name=name) if "{name}" in GIVEN[name] else GIVEN[name]
    if _is_framework(name):
        return f"{name} = nrp.{name}"
    return ""


def _is_framework(name: str) -> bool:
    return name in dsl.__all__


def _lacking(tree: ast.Module) -> set[str]:
    """Return the undefined names that code uses."""
    nodes = list(ast.walk(tree))
    elsewhere = {name for node in nodes if isinstance(node, ast.Global) for name in node.names}
    elsewhere -= {*defined(tree)}
    known = {*vars(builtins), *file_names(), "__file__", *_all_defined(tree)} - elsewhere
    used = {node.id for node in nodes if isinstance(node, ast.Name)}
    return used - known


def _all_defined(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, (ast.Store, ast.Del)):
            yield node.id
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            yield from ((alias.asname or alias.name).partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ExceptHandler) and node.name:
            yield node.name
