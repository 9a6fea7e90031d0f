"""Whether a run without an end waits until it is stopped.

``run_forever`` of sPyNNaker 7.4.1 returns when another thread stops the run; that of its early versions
returned at once, and the script stopped the run itself. The place from which a script stops the run, or waits
for its end, tells for which of them it was written.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Final

_STOPS: Final = {"request_stop", "stop_run"}
_BEGINS: Final = {"run_forever"}
_WAITS: Final = {"input", "join", "mainloop", "raw_input", "show", "sleep", "wait", *_STOPS}
"""What a script does while its network runs beside it."""


def stops_elsewhere(source: bytes) -> bool:
    """Return whether other code than that which begins a run stops it, or nothing in the script does."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):  # the script is refused when it runs, or is not in this language
        return False
    functions = [each for each in ast.walk(tree) if isinstance(each, (ast.FunctionDef, ast.Lambda))]
    called = [{*_called(each)} for each in functions]
    if any(_STOPS & names and not _BEGINS & names for names in called):
        return True
    apart = {id(part) for each in functions for part in ast.walk(each)}
    own = {_name(each) for each in ast.walk(tree) if isinstance(each, ast.Call) and id(each) not in apart}
    beginning = [names for names in (own, *called) if _BEGINS & names]
    return bool(beginning) and not any(_WAITS & names for names in (own, *beginning))


def _name(call: ast.Call) -> str:
    return str(getattr(call.func, "attr", getattr(call.func, "id", "")))


def _called(function: ast.AST) -> Iterator[str]:
    for each in ast.walk(function):
        if isinstance(each, ast.Call):
            yield _name(each)
