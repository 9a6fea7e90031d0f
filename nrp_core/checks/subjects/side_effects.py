"""Calls that wait, end the process, write files, or depend on more than the run."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from nrp_core.checks.check import checks_function
from nrp_core.checks.code.syntax import excerpt, full_names
from nrp_core.checks.code.values import Known
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.findings import Code, Finding, Level


class _Effect(NamedTuple):
    """What calls of some names do; ``{}`` in the message stands for the name."""

    code: Code
    level: Level
    message: str
    names: str
    """A regular expression of full names."""


_EFFECTS: Final = [
    _Effect(Code.NRP357, Level.WARNING, "'{}' stops the whole loop: simulated time stands still meanwhile",
            r"time\.sleep"),
    _Effect(Code.NRP357, Level.WARNING,
            "'{}' returns at once: simulated time stands still while a transfer function runs",
            r"rospy\.sleep"),
    _Effect(Code.NRP243, Level.NOTE, "'{}' differs between runs",
            r"time\.(time|clock|perf_counter|monotonic|process_time)(_ns)?|os\.urandom|uuid\.uuid4"
            r"|datetime(\.datetime)?\.(now|today)|random\.(?!Random$|seed$)\w+|numpy\.random\.[a-z]\w*(?<!_rng)"),
    _Effect(Code.NRP243, Level.WARNING, "'{}' ends the process of the run; return instead",
            r"exit|quit|sys\.exit|os\.(_exit|abort)|SystemExit|KeyboardInterrupt"),
    _Effect(Code.NRP378, Level.WARNING,
            "'{}' writes a file, which a replay writes again: record values with nrp.MapCSVRecorder",
            r"numpy\.save\w*|scipy\.io\.savemat|torch\.save|cv2\.imwrite|joblib\.dump"),
]  # fmt: skip
_OPENERS: Final = frozenset({"open", "io.open", "codecs.open", "gzip.open", "bz2.open", "lzma.open"})
_WRITING: Final = frozenset("wax+")
_WRITING_METHODS: Final = ("write_text", "write_bytes", "tofile", "savefig")


@checks_function
def check_effects(function: CheckedFunction) -> Iterator[Finding]:
    """Look for calls that wait, write files, depend on more than the run, or end the process."""
    imported = full_names(function.declared.source.tree)
    roots = {name.partition(".")[0] for name in imported}
    raised = {id(one.exc) for one in function.declared.own if isinstance(one, ast.Raise)}
    for node in function.declared.own:
        match node:
            case ast.Call(called):
                pass
            case ast.Name() as called if id(node) in raised:
                pass
            case _:
                continue
        if isinstance(called, ast.Attribute) and _writes_by_method(node, called.attr):
            yield _finding(function, node, _EFFECTS[-1], excerpt(node))
        root, name = ast.unparse(called).partition(".")[0], _full_name(called, imported)
        is_set = root in function.declared.names and root not in roots
        if is_set or function.body.is_local(root):
            continue
        if name in _OPENERS and _opens_for_writing(node, 1):
            yield _finding(function, node, _EFFECTS[-1], excerpt(node))
        for effect in _EFFECTS:
            is_other = effect.level is Level.NOTE and _is_substitute(function, root)
            if re.fullmatch(effect.names, name) and not is_other:
                yield _finding(function, node, effect, ast.unparse(called))


def _finding(function: CheckedFunction, node: ast.AST, effect: _Effect, text: str) -> Finding:
    return function.declared.finding(effect.code, node, effect.message.format(text), effect.level)


def _is_substitute(function: CheckedFunction, root: str) -> bool:
    """Return whether a name is not what it says but a substitute of ours, as for another platform's code."""
    found = function.declared.names.get(root)
    return isinstance(found, Known) and not str(getattr(found.value, "__name__", "")).startswith("numpy")


def _full_name(node: ast.expr, imported: dict[str, str]) -> str:
    """Return the full name of something called; empty for a result or an item."""
    written = ast.unparse(node)
    if not re.fullmatch(r"[\w.]+", written):
        return ""
    root, dot, rest = written.partition(".")
    return imported.get(root, root) + dot + rest


def _writes_by_method(node: ast.AST, method: str) -> bool:
    """Return whether the call of a method certainly writes a file."""
    if method == "to_csv":  # without an argument it returns a text
        return isinstance(node, ast.Call) and bool(node.args)
    return method in _WRITING_METHODS or (method == "open" and _opens_for_writing(node, 0))


def _opens_for_writing(node: ast.AST, index: int) -> bool:
    """Return whether the mode of an opened file, the argument at ``index``, allows to write."""
    if not isinstance(node, ast.Call):
        return False
    given = [one.value for one in node.keywords if one.arg == "mode"] or node.args[index : index + 1]
    mode = given[0].value if given and isinstance(given[0], ast.Constant) else None
    return isinstance(mode, str) and len(mode) < 5 and bool(_WRITING & set(mode))
