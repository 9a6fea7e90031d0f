"""What a run does not control, record or replay, and calls that end its process."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from nrp_core.checks.code.declarations import local_names, used_functions
from nrp_core.checks.code.shapes import full_names
from nrp_core.checks.code.syntax import excerpt
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
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


_BESIDE = ("threading.Thread", "threading.Timer", "multiprocessing.", "subprocess.", "concurrent.futures.",
           "asyncio.", "os.system", "os.popen", "os.fork")  # fmt: skip
_REMOTE = ("urllib.request.", "requests.", "socket.", "http.client.", "httpx.")
_VARIABLES = ("os.environ", "os.getenv")
_UNSEEDED = frozenset({"numpy.random.default_rng", "numpy.random.seed", "numpy.random.RandomState",
                       "random.seed", "random.Random"})  # fmt: skip
"""Generators that start from the entropy of the machine if they get no seed."""
_CHANCE = frozenset({"time.time", "time.time_ns", "time.perf_counter", "time.monotonic", "os.urandom",
                     "uuid.uuid4", "datetime.datetime.now", "datetime.datetime.today"})  # fmt: skip
_NAME = re.compile(r"\w+(\.\w+)*")


@checks_function(Code.NRP243)
def nothing_comes_from_outside(function: CheckedFunction) -> Iterator[Finding]:
    """Look for uses of the environment that a run does not control, record or replay."""
    imported = full_names(function.declared.source.tree)
    for used in used_functions(function.declared):
        own = local_names(used)
        for node in ast.walk(used):
            if not isinstance(node, ast.Attribute | ast.Name) or not isinstance(node.ctx, ast.Load):
                continue
            message = _outside(_full_name(node, own, imported), ast.unparse(node))
            if message:
                yield function.declared.finding(Code.NRP243, node, message, Level.WARNING)


def _full_name(node: ast.expr, own: set[str], imported: dict[str, str]) -> str:
    """Return the name of something imported; empty for anything else."""
    written = ast.unparse(node)
    if not _NAME.fullmatch(written):
        return ""
    root, dot, rest = written.partition(".")
    if root in own:
        return ""
    if root in imported:
        return imported[root] + dot + rest
    return written if any(module.startswith(f"{root}.") for module in imported) else ""


def _outside(name: str, written: str) -> str:
    """Return why something makes runs differ; empty if it does not."""
    if name in _VARIABLES:
        return (
            f"'{written}' reads a variable of the machine, which no recording keeps: "
            "declare a parameter, nrp.parameter(...)"
        )
    if name.startswith(_BESIDE) and name.count("."):
        return f"'{written}' runs beside the loop: what it does at which step is another thing in each run"
    if name.startswith(_REMOTE):
        return f"'{written}' uses the network: what it answers is in no recording"
    return ""


@checks_experiment(Code.NRP243)
def brain_scripts_repeat(static: StaticExperiment) -> Iterator[Finding]:
    """Look for what makes a brain script build another network in each run."""
    path = static.experiment.brain.model
    try:
        tree = ast.parse(path.read_bytes() if path.suffix == ".py" else b"")
    except (OSError, SyntaxError, ValueError):  # reported where it is executed
        return
    imported = full_names(tree)
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    seeds = {inner for call in calls for seed in _seeds(call, imported) for inner in ast.walk(seed)}
    for node in calls:
        name = _full_name(node.func, set(), imported)
        written = excerpt(node)
        if name in _UNSEEDED and not node.args and not node.keywords:
            message, level = f"'{written}' has no seed: it is another one in each run", Level.WARNING
        elif name in _CHANCE and node in seeds:
            message, level = f"'{written}' is part of a seed and another one in each run", Level.WARNING
        elif name in _CHANCE:
            message, level = f"'{written}' is another one in each run", Level.NOTE
        else:
            continue
        yield Finding(Code.NRP243, message, level, path, node.lineno, node.col_offset + 1)


def _seeds(call: ast.Call, imported: dict[str, str]) -> Iterator[ast.expr]:
    """Yield the arguments of a call that seed something."""
    yield from (keyword.value for keyword in call.keywords if keyword.arg == "seed")
    if _full_name(call.func, set(), imported) in _UNSEEDED:
        yield from call.args
