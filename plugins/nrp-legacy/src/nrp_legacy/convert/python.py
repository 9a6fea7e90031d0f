"""Transfer functions of the platform as files of ours: the same code, with other imports and spellings."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterator
from dataclasses import dataclass

from nrp_core import dsl
from nrp_core.dsl.devices.kinds import DeviceKind
from nrp_core.dsl.loading.loader import file_names
from nrp_legacy.code import Source, as_of_old, defined
from nrp_legacy.convert.edits import Edits
from nrp_legacy.convert.reliance import reliance
from nrp_legacy.framework import SPELLINGS
from nrp_legacy.notes import unnoted
from nrp_legacy.outdated import ROUND
from nrp_legacy.python2 import DIVIDE, converted, rewritten
from nrp_legacy.shims.graph import absolute

FRAMEWORKS = ("hbp_nrp_cle.tf_framework", "python_cle.tf_framework")
_PACKAGES = ("hbp_nrp_cle", "python_cle")
_NOT_HERE = ("rospy", "smach", "smach_ros", "hbp_nrp_excontrol", "tf", "nest", "dynamic_reconfigure")
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
        lacks: the names that it uses but nothing defines.
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
        obstacle: a feature of the platform that it is known to need.

    Raises:
        TransferFunctionError: it is not Python.
    """
    text, changes = modern(source)
    with as_of_old():
        tree = ast.parse(text)
    relied = reliance(tree)
    work = _Work(text, obstacle or (f"relies on {relied}" if relied else ""))
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
    source.tree(unnoted)  # reported by its own error
    with as_of_old():
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
    with as_of_old():
        return bool(converted(text).changes)


class _Work(ast.NodeVisitor):
    def __init__(self, text: str, obstacle: str) -> None:
        self.edits = Edits(text)
        self.changes: list[str] = []
        self.obstacle = obstacle

    def visit_Import(self, node: ast.Import) -> None:
        new: list[str] = []
        for alias in node.names:
            if alias.name in FRAMEWORKS:
                new += [f"{alias.asname} = nrp"] if alias.asname not in (None, "nrp") else []
            elif alias.name.partition(".")[0] not in _PACKAGES:
                self._check(alias.name)
                new.append(f"import {alias.name}" + (f" as {alias.asname}" if alias.asname else ""))
        self._imports(node, new)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        module = node.module or ""
        if module == _LOGS:
            self._imports(node, [])
        elif module.partition(".")[0] not in _PACKAGES:
            self._check(module)
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
            self.obstacle = self.obstacle or "uses rospy"

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

    def _check(self, module: str) -> None:
        if module.partition(".")[0] in _NOT_HERE:
            self.obstacle = self.obstacle or f"imports {module}"


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
