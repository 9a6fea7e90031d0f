"""What the functions of a run recorded."""

from __future__ import annotations

from typing import Any

from nrp_core.experiment.running.run import Run


def rows(run: Run, function: str, parameter: str) -> list[list[str]]:
    """Return the rows that a function has written with one of its recorders."""
    adapters: dict[str, Any] = {one.name: one.adapters for one in run.loop.functions}
    recorded: list[list[str]] = adapters[function][parameter].rows
    return recorded
