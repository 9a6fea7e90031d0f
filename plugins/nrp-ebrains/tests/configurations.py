"""Entries of configurations of NRP-core 4."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

Write = Callable[..., Path]
"""Writes a configuration and its Python files, by name, and returns the configuration's path."""


def python_engine(
    name: str, file: str, step_s: float | None = None, kind: str = "python_json"
) -> dict[str, Any]:
    """Return the entry of a Python engine."""
    engine: dict[str, Any] = {"EngineType": kind, "EngineName": name, "PythonFileName": f"{file}.py"}
    return engine if step_s is None else {**engine, "EngineTimestep": step_s}


def functions(*names: str) -> list[dict[str, str]]:
    """Return the entries of functions, each in a file of its name."""
    return [{"Name": name, "FileName": f"{name}.py"} for name in names]
