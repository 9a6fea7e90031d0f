"""Findings in the formats that other programs read: SARIF 2.1.0 and the annotations of GitHub Actions.

Sources: OASIS, "Static Analysis Results Interchange Format (SARIF) Version 2.1.0"; GitHub, "Workflow commands
for GitHub Actions".
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nrp_core.findings import Code, Finding, Level

_GITHUB = {Level.ERROR: "error", Level.WARNING: "warning", Level.NOTE: "notice"}
_ESCAPES = {"%": "%25", "\r": "%0D", "\n": "%0A"}
_PROPERTY_ESCAPES = {**_ESCAPES, ":": "%3A", ",": "%2C"}


def sarif(findings: Sequence[Finding]) -> dict[str, Any]:
    """Return a SARIF log with one run."""
    codes = sorted({finding.code for finding in findings}, key=lambda code: code.name)
    driver = {
        "name": "nrp validate",
        "version": version("nrp-core"),
        "rules": [_rule(code) for code in codes],
    }
    return {
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [
            {
                "tool": {"driver": driver},
                "columnKind": "unicodeCodePoints",
                "results": [_result(finding, codes.index(finding.code)) for finding in findings],
            }
        ],
    }


def _rule(code: Code) -> dict[str, Any]:
    return {
        "id": code.name,
        "shortDescription": {"text": code.summary},
        "fullDescription": {"text": code.why},
        "help": {"text": code.suggestion},
    }


def _result(finding: Finding, rule: int) -> dict[str, Any]:
    result: dict[str, Any] = {
        "ruleId": finding.code.name,
        "ruleIndex": rule,
        "level": str(finding.level),
        "message": {"text": finding.message},
    }
    if finding.path is not None:
        region = {"startLine": finding.line, "startColumn": finding.column}
        place: dict[str, Any] = {"artifactLocation": {"uri": _uri(finding.path)}}
        if finding.line is not None:
            place["region"] = {key: value for key, value in region.items() if value is not None}
        result["locations"] = [{"physicalLocation": place}]
    return result


def _uri(path: Path) -> str:
    """Return the URI of a file, relative if it is below the current folder."""
    absolute = path.absolute()
    if absolute.is_relative_to(Path.cwd()):
        return quote(absolute.relative_to(Path.cwd()).as_posix())
    return absolute.as_uri()


def github(findings: Iterable[Finding]) -> Iterable[str]:
    """Yield a workflow command for each finding, which GitHub shows at its line."""
    for finding in findings:
        place = {
            "file": None if finding.path is None else _relative(finding.path),
            "line": finding.line, "col": finding.column, "title": finding.code.name,
        }  # fmt: skip
        properties = ",".join(
            f"{key}={_escaped(str(value), _PROPERTY_ESCAPES)}"
            for key, value in place.items()
            if value is not None
        )
        yield f"::{_GITHUB[finding.level]} {properties}::{_escaped(finding.message, _ESCAPES)}"


def _relative(path: Path) -> Path:
    absolute = path.absolute()
    return absolute.relative_to(Path.cwd()) if absolute.is_relative_to(Path.cwd()) else absolute


def _escaped(text: str, escapes: dict[str, str]) -> str:
    return "".join(escapes.get(character, character) for character in text)
