"""Commands to a run from outside."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from nrp_core.dsl.functions import TransferFunction
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.making.maker import load_function_file
from nrp_core.experiment.running.control import Commands
from nrp_core.experiment.running.run import PARTS, Run


def commands_of(run: Run) -> Commands:
    """Return the commands of a run, by name."""

    def change(add: list[str], remove: list[str], activate: list[str], deactivate: list[str]) -> list[Any]:
        """Change the transfer functions, then activate or deactivate some; return the present ones.

        Raises:
            ExperimentError: two changes of one function contradict each other, or one is wrong.
        """
        twice = Counter([*set(activate), *set(deactivate), *set(remove)])
        for name in (name for name, count in twice.items() if count > 1):
            raise ExperimentError(f"'{name}' is to be activated, deactivated or removed, not two of these")
        _require(run, [Path(path) for path in add], {*activate, *deactivate})
        run.change(map(Path, add), remove)
        for names, active in ((activate, True), (deactivate, False)):
            for name in names:
                run.activate(name, active)
        failed = {failure.function: str(failure) for failure in run.loop.failures}
        return [_describe(function, failed.get(function.name)) for function in run.loop.functions]

    def publish(topic: str, value: Any) -> list[str]:
        """Publish a message; return the active functions that publish on the topic, too."""
        run.publish(topic, value)
        name = run.world.advertise(topic).topic.name
        active = (one for one in run.loop.functions if one.active)
        return [
            one.name
            for one in active
            if any(run.world.advertise(published.name).topic.name == name for published in one.published)
        ]

    def reset(part: str) -> None:
        """Reset one part without changing the time.

        Raises:
            ExperimentError: it cannot be reset alone.
        """
        if part == "all":
            raise ExperimentError(f"only one of {', '.join(PARTS)} can be reset while the run goes on")
        run.reset(part)

    return {"publish": publish, "functions": change, "reset": reset}


def _require(run: Run, added: Iterable[Path], names: set[str]) -> None:
    """Refuse unknown names of functions, also unknown in added files, before anything changes."""
    known = {function.name for function in run.loop.functions}
    if names <= known:
        return
    for path in added:
        known |= {function.name for function in load_function_file(path, run.experiment.function_parameters)}
    for name in sorted(names - known):
        raise ExperimentError(f"no transfer function '{name}'{did_you_mean(name, known)}")


def _describe(function: TransferFunction, failure: str | None) -> dict[str, Any]:
    return {
        "name": function.name,
        "place": str(function.place),
        "flow": function.flow.value,
        "priority": function.priority,
        "active": function.active,
        "failure": None if function.active else failure,
    }
