"""Build a network and describe it on standard output: the child process of :mod:`nrp_core.analysis.network`.

It trusts its argument, which is made by its parent: a pickle.
"""

from __future__ import annotations

import base64
import json
import os
import pickle
import sys
from typing import Any

from nrp_core.analysis.skeleton import described
from nrp_core.errors import ExperimentError, NrpError


def main(question: str) -> int:
    """Answer one question; what a script prints goes to standard error.

    Returns:
        1 if there is no network, so that the answer is not kept: what was missing may be there next time.
    """
    stream = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    answer = _answer(question)
    with stream:
        json.dump(answer, stream)
    return int("error" in answer)


def _answer(question: str) -> dict[str, Any]:
    try:
        make, backend, parts = pickle.loads(base64.b64decode(question))
        network = make()
    except NrpError as error:
        return {"error": _told(error)}
    warnings: list[str] = []
    refusal = None
    try:
        if backend is not None:
            kind, values = parts
            warnings = backend.warnings(network, kind.model_construct(**values))
    except NrpError as error:
        refusal = _told(error)
    return {"network": described(network), "warnings": warnings, "refusal": refusal}


def _told(error: NrpError) -> dict[str, Any]:
    told: dict[str, Any] = {"kind": type(error).__name__, "message": getattr(error, "message", str(error))}
    if isinstance(error, ExperimentError):
        told |= {
            "path": None if error.path is None else str(error.path),
            "line": error.line, "column": error.column,
        }  # fmt: skip
    return told


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
