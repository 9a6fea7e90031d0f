"""Build a network in a confined process, and describe it on standard output or write it into a file.

The child process of :mod:`nrp_core.checks.confined_network`. It trusts its argument, a pickle that its parent
made. Its parent does not trust its answer, which is made by the code of an experiment: JSON, or a network
file. Imports are inside functions, because a process is confined while it has a single thread.
"""

from __future__ import annotations

import base64
import json
import os
import pickle
import sys
from collections.abc import Callable
from errno import ENOENT
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nrp_core._support.confinement import confine, noting_variables, values_of
from nrp_core.errors import ExperimentError, NrpError, UncheckedScriptError
from nrp_core.findings import Code, Findings

if TYPE_CHECKING:
    from nrp_core.network.data import Network

_KERNELS = "NUMBA_CACHE_DIR"
_CONFINED = "a check executes the script without network access, and it can only write temporary files"
_NETWORK_BYTES = 100_000_000_000
"""The largest file of a network."""


def load() -> None:
    """Import the modules that every answer uses."""
    import nrp_core.checks.network_summary
    import nrp_core.network.files
    import nrp_core.pynn  # noqa: F401


def main(question: str, cpu_s: str, target: str, scratch: str) -> int:
    """Answer one question; the output of a script goes to standard error.

    Args:
        question: the pickle, in base64.
        cpu_s: the processor time after which this process is ended, s.
        target: the file to write the network into; if it is empty, the network is described.
        scratch: a folder for temporary files.

    Returns:
        1 if the network could not be built, so that the result is not cached.
    """
    stream = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    if target:
        lacking = confine(
            cpu_s=float(cpu_s), writable=[Path(scratch), Path(target).parent], file_bytes=_NETWORK_BYTES
        )
    else:
        lacking = confine(cpu_s=float(cpu_s), writable=[Path(scratch)])
    os.environ[_KERNELS] = scratch  # no other place can be written
    answer = {"error": _refused(lacking)} if lacking else _answer(question, target)
    with stream:
        json.dump(answer, stream)
    return int("error" in answer)


def _refused(lacking: list[str]) -> dict[str, Any]:
    """Return the error that a script is not executed."""
    message = (
        "the brain script was not executed, because this system cannot confine it: "
        f"{' and '.join(lacking)} cannot be used; --trust executes it with your permissions"
    )
    return _reported(UncheckedScriptError(message))


def _answer(question: str, target: str) -> dict[str, Any]:
    try:
        make, backend, parts = pickle.loads(base64.b64decode(question))
        network, variables = _made(make)
        if target:
            from nrp_core.network.files import save_network

            save_network(network, Path(target))
            return {}
    except NrpError as error:
        return {"error": _reported(error)}
    return {**_described(network, backend, parts), "variables": variables}


def _made(make: Callable[[], Network]) -> tuple[Network, dict[str, str | None]]:
    """Return a network and the environment variables that it depends on."""
    load()  # before: libraries read variables of their own
    with noting_variables() as noted:
        network = make()
    return network, values_of(noted - {_KERNELS})


def _described(network: Network, backend: Any, parts: Any) -> dict[str, Any]:
    from nrp_core.checks.network_summary import described

    warnings = Findings(general=Code.NRP217)
    refusal = None
    try:
        if backend is not None:
            kind, values = parts
            warnings += backend.warnings(network, kind.model_construct(**values))
    except NrpError as error:
        refusal = _reported(error)
    return {
        "network": described(network),
        "warnings": [one.to_dict() for one in warnings],
        "refusal": refusal,
    }


def _reported(error: NrpError) -> dict[str, Any]:
    data: dict[str, Any] = {"kind": type(error).__name__, "message": getattr(error, "message", str(error))}
    if is_refused(error):
        data["message"] += f" ({_CONFINED})"
    if isinstance(error, ExperimentError):
        data |= {
            "path": None if error.path is None else str(error.path),
            "line": error.line, "column": error.column, "subject": error.subject,
        }  # fmt: skip
    return data


def is_refused(error: BaseException | None) -> bool:
    """Return whether an error comes from a file or an address that this process may not use.

    An error of the system has a number; a library's own about the contents of a file has none.
    """
    while error is not None:
        if isinstance(error, OSError) and error.errno not in (None, ENOENT):
            return True
        error = error.__cause__ or error.__context__
    return False


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
