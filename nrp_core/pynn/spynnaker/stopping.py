"""Whether a run without an end waits until it is stopped.

``run_forever`` of sPyNNaker 7.4.1 returns when another thread stops the run; that of its early versions
returned at once, and the script stopped the run itself. The place from which a script stops the run tells for
which of them it was written.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

_STOPS: Final = {"request_stop", "stop_run"}
_BEGINS: Final = {"run_forever"}


def stops_elsewhere(source: bytes) -> bool:
    """Return whether a function stops a run that it does not begin itself, as a callback does."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):  # the script is refused when it runs
        return False
    functions = (each for each in ast.walk(tree) if isinstance(each, (ast.FunctionDef, ast.Lambda)))
    called = ({*_called(each)} for each in functions)
    return any(_STOPS & names and not _BEGINS & names for names in called)


def _called(function: ast.AST) -> Iterator[str]:
    for each in ast.walk(function):
        if isinstance(each, ast.Call):
            yield getattr(each.func, "attr", getattr(each.func, "id", ""))
