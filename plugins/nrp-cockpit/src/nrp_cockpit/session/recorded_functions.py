"""The transfer functions of a recorded run, read from the files in its recording and never executed."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from nrp_cockpit.session.functions import source_file
from nrp_core import dsl
from nrp_core.dsl import Flow
from nrp_core.errors import NrpError
from nrp_core.experiment import LISTERS


def recorded_functions(paths: Iterable[Path], failures: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the functions that files declare, and the files.

    Args:
        paths: the files.
        failures: failures of the functions, as in a result.
    """
    paths, failed = tuple(paths), {failure["function"]: failure for failure in failures}
    found: dict[str, dict[str, Any]] = {}
    for path in paths:
        for name, line, flow in _declared(path):
            found.setdefault(name, _function_data(name, path, line, flow, failed.get(name)))
    return {
        "functions": list(found.values()),
        "files": [source_file(str(path), path, editable=False) for path in paths],
    }


def _declared(path: Path) -> Iterator[tuple[str, int, str]]:
    """Yield name, line and direction of the functions in a file."""
    try:
        sources = LISTERS.load(path.suffix)(path).sources
    except NrpError:
        return  # the source shows the rest
    for node in (node for source in sources for node in ast.walk(source.tree)):
        if not isinstance(node, ast.FunctionDef):
            continue
        words = {word for each in node.decorator_list for word in _words(each)}
        if words.intersection(dsl.__all__):
            to_robot = Flow.NEURON_TO_ROBOT.value
            yield node.name, node.lineno, to_robot if to_robot in words else Flow.ROBOT_TO_NEURON.value


def _words(decorator: ast.expr) -> Iterator[str]:
    """Yield the names in a decorator, such as those of ``nrp.Neuron2Robot(...)``."""
    for node in ast.walk(decorator):
        if isinstance(node, ast.Name | ast.Attribute):
            yield node.id if isinstance(node, ast.Name) else node.attr


def _function_data(
    name: str, path: Path, line: int, flow: str, failure: Mapping[str, Any] | None
) -> dict[str, Any]:
    return {
        "name": name,
        "file": str(path),
        "line": line,
        "flow": flow,
        "active": failure is None,
        "failure": failure
        and {
            "t_s": failure["t_s"],
            "message": failure["error"],
            "traceback": failure["error"],
            "stops": False,
        },
        "calls": 0,
        "since_s": 0.0,
        "mean_ms": 0.0,
        "recent_ms": [],
    }
