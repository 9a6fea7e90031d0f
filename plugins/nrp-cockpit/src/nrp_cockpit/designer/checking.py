"""Findings about a model, each at its box."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from nrp_bibi.generation.part import CodePart
from nrp_bibi.generation.transformation import transformed
from nrp_bibi.model.functions import Bibi
from nrp_bibi.writer import bibi_text

from nrp_cockpit.designer.tree import FUNCTIONS, function_of, path_at_line
from nrp_core.errors import ExperimentError

_CODE = "BIBI"


def model_findings(model: Bibi, path: Path) -> list[dict[str, Any]]:
    """Return the reasons why a model cannot become Python: for each function, then for all together."""
    found = [finding for place in range(len(model.transfer_function))
             for finding in _of_function(model, place, path)]  # fmt: skip
    return found or list(_of_all(model, path))


def generated(model: Bibi, path: Path) -> dict[str, Any]:
    """Return the Python of a model, and for each of its lines the line in the model.

    Returns:
        ``text``, ``lines`` and, if there is no Python, ``error``.
    """
    try:
        parts = transformed(model, path)
    except ExperimentError as error:
        return {"text": "", "lines": [], "error": error.message}
    lines: list[int] = []
    for part in parts:
        lines += [*([0, 0] if lines else []), *_own_lines(part, path)]
    return {"text": "\n\n\n".join(part.text for part in parts) + "\n", "lines": lines, "error": None}


def located(model: Bibi, path: Path, findings: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the findings of a check of the experiment, and for those about this model their places in it."""
    return [_placed(model, dict(finding), path) for finding in findings]


def _placed(model: Bibi, finding: dict[str, Any], path: Path) -> dict[str, Any]:
    here = finding["file"] is not None and Path(finding["file"]) == path
    where = path_at_line(model, finding["line"]) if here and finding["line"] else ""
    return {**finding, "path": where, "box": function_of(where)}


def _of_function(model: Bibi, place: int, path: Path) -> Iterator[dict[str, Any]]:
    alone = replace(model, transfer_function=model.transfer_function[place : place + 1])
    try:
        for part in transformed(alone, path):
            part.source()
    except ExperimentError as error:
        function = f"{FUNCTIONS}/{place}"
        where = path_at_line(model, error.line) if error.line else function
        yield _finding(error, where if where.startswith(function) else function)


def _of_all(model: Bibi, path: Path) -> Iterator[dict[str, Any]]:
    try:
        transformed(model, path)
        bibi_text(model)
    except ExperimentError as error:
        yield _finding(error, path_at_line(model, error.line) if error.line else "")


def _finding(error: ExperimentError, where: str) -> dict[str, Any]:
    return {
        "code": _CODE, "weight": "error", "summary": error.message, "why": "", "fix": "", "count": 1,
        "file": None if error.path is None else str(error.path), "line": error.line,
        "path": where, "box": function_of(where),
    }  # fmt: skip


def _own_lines(part: CodePart, path: Path) -> list[int]:
    return list(part.lines) if part.path == path else [0] * len(part.lines)
