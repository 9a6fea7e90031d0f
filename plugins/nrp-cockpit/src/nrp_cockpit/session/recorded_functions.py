"""The transfer functions of a recorded run, read from the files in its recording and never executed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from nrp_cockpit.session.functions import source_file
from nrp_core.checks.code.declarations import Declarations
from nrp_core.dsl import TransferFunction
from nrp_core.errors import NrpError
from nrp_core.experiment.making.maker import LISTERS


def recorded_functions(paths: Iterable[Path], failures: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the functions that files declare, and the files.

    Args:
        paths: the files.
        failures: failures of the functions, as in a result.
    """
    paths, failed = tuple(paths), {failure["function"]: failure for failure in failures}
    found: dict[str, dict[str, Any]] = {}
    for path in paths:
        for function in _declared(path):  # one in a loop has many names
            found.setdefault(function.name, _function_data(function, path, failed.get(function.name)))
    return {
        "functions": list(found.values()),
        "files": [source_file(str(path), path, editable=False) for path in paths],
    }


def _declared(path: Path) -> Iterator[TransferFunction]:
    try:
        declarations = Declarations(LISTERS.load(path.suffix)(path))
    except NrpError:
        return  # the source shows the rest
    for declared in declarations.functions:
        yield declared.function


def _function_data(
    function: TransferFunction, path: Path, failure: Mapping[str, Any] | None
) -> dict[str, Any]:
    return {
        "name": function.name,
        "file": str(path),
        "line": function.place.line,
        "flow": function.flow.value,
        "active": function.active and failure is None,
        "failure": failure
        and {
            "t_s": failure["t_s"],
            "message": failure["error"],
            "traceback": failure["error"],
            "stops": False,
        },
        "calls": 0,
        "mean_ms": 0.0,
        "recent_ms": [],
    }
