"""Commands to a run from outside."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.experiment.running.control import Commands
from nrp_core.experiment.running.run import Run


def commands_of(run: Run) -> Commands:
    """Return the commands of a run, by name."""

    def change(add: list[str], remove: list[str], activate: list[str], deactivate: list[str]) -> list[Any]:
        """Change the transfer functions, then activate or deactivate some; return the present ones."""
        run.change(map(Path, add), remove)
        for names, active in ((activate, True), (deactivate, False)):
            for name in names:
                run.activate(name, active)
        failed = {failure.function: str(failure) for failure in run.loop.failures}
        return [_shown(function, failed.get(function.name)) for function in run.loop.functions]

    return {"publish": run.publish, "functions": change, "reset": run.reset}


def _shown(function: TransferFunction, failure: str | None) -> dict[str, Any]:
    return {
        "name": function.name,
        "place": str(function.place),
        "flow": function.flow.value,
        "priority": function.priority,
        "active": function.active,
        "failure": None if function.active else failure,
    }
