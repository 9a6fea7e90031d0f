"""Functions that end the process or handle its signals."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.imported import full_names
from nrp_core.checks.registry import checks_function
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.checks.used import local_names, used_functions
from nrp_core.findings import Code, Finding, Level

_BUILTINS = frozenset({"exit", "quit"})
_ENDINGS = frozenset({"sys.exit", "os._exit", "os.abort", "os.kill", "os.killpg", "signal.raise_signal"})
_SIGNALS = frozenset({"signal.signal", "signal.alarm", "signal.setitimer"})
_EXCEPTIONS = frozenset({"SystemExit", "KeyboardInterrupt"})


@checks_function(Code.NRP302)
def the_process_goes_on(function: CheckedFunction) -> Iterator[Finding]:
    """Look for calls and exceptions that end the process, and for handlers of signals."""
    imported = full_names(function.declared.source.tree)
    known = imported.keys() | function.declared.names.keys()
    for used in used_functions(function.declared):
        own = local_names(used)
        for node in ast.walk(used):
            message = ""
            if isinstance(node, ast.Call) and not _only_asks(node):
                message = _wrong(node.func, own, imported, known)
            elif isinstance(node, ast.Raise) and node.exc is not None:
                raised = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
                if isinstance(raised, ast.Name) and raised.id in _EXCEPTIONS - known - own:
                    message = f"'raise {raised.id}' ends the process of the run; return instead"
            if message:
                yield function.declared.finding(Code.NRP302, node, message, Level.WARNING)


def _wrong(callee: ast.expr, own: set[str], imported: dict[str, str], known: set[str]) -> str:
    """Return why something must not be called; empty if it may."""
    name = ast.unparse(callee)
    root, dot, rest = name.partition(".")
    if root in own:
        return ""
    called = imported.get(root, "") + dot + rest
    if called in _SIGNALS:
        return f"'{name}' handles signals of the whole process, with which a run is interrupted"
    if called in _ENDINGS or name in _BUILTINS - known:
        return f"'{name}' ends the process of the run; return instead"
    return ""


def _only_asks(call: ast.Call) -> bool:
    """Return whether a signal is 0, which only checks whether a process exists."""
    return len(call.args) == 2 and isinstance(call.args[1], ast.Constant) and call.args[1].value == 0
