"""Calls with effects that a run does not control, record or replay, or that end its process."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from typing import Final, NamedTuple

from nrp_core.checks.check import checks_experiment, checks_function
from nrp_core.checks.code.syntax import excerpt, full_names
from nrp_core.checks.code.values import Known
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.findings import Code, Finding, Level


class _Effect(NamedTuple):
    """What calls of some names do; ``{}`` in the message stands for the name."""

    code: Code
    level: Level
    message: str
    names: str
    """A regular expression of full names."""


_EFFECTS: Final = [
    _Effect(Code.NRP243, Level.WARNING, "'{}' stops the whole loop: simulated time stands still meanwhile",
            r"time\.sleep"),
    _Effect(Code.NRP357, Level.WARNING,
            "'{}' returns at once: simulated time stands still while a transfer function runs",
            r"rospy\.sleep"),
    _Effect(Code.NRP243, Level.NOTE, "'{}' differs between runs",
            r"time\.(time|clock|perf_counter|monotonic|process_time)(_ns)?|os\.urandom|uuid\.uuid4"
            r"|datetime(\.datetime)?\.(now|today)|random\.(?!Random$|seed$)\w+|numpy\.random\.[a-z]\w*(?<!_rng)"),
    _Effect(Code.NRP243, Level.WARNING,
            "'{}' runs beside the loop: what it does at which step is another thing in each run",
            r"threading\.(Thread|Timer)|(multiprocessing|subprocess|concurrent\.futures|asyncio)\..*"
            r"|os\.(system|popen|fork)"),
    _Effect(Code.NRP243, Level.WARNING, "'{}' uses the network: what it answers is in no recording",
            r"(urllib\.request|requests|socket|http\.client|httpx)\..*"),
    _Effect(Code.NRP243, Level.WARNING,
            "'{}' reads a variable of the machine: declare a parameter, nrp.parameter(...)",
            r"os\.(environ(\.get)?|getenv)"),
    _Effect(Code.NRP302, Level.WARNING, "'{}' ends the process of the run; return instead",
            r"exit|quit|sys\.exit|os\.(_exit|abort|kill|killpg)|signal\.raise_signal"
            r"|SystemExit|KeyboardInterrupt"),
    _Effect(Code.NRP302, Level.WARNING,
            "'{}' handles signals of the whole process, with which a run is interrupted",
            r"signal\.(signal|alarm|setitimer)"),
    _Effect(Code.NRP378, Level.WARNING,
            "'{}' writes a file, which a replay writes again: record values with nrp.MapCSVRecorder",
            r"numpy\.save\w*|scipy\.io\.savemat|torch\.save|cv2\.imwrite|joblib\.dump"),
]  # fmt: skip
_OPENERS: Final = frozenset({"open", "io.open", "codecs.open", "gzip.open", "bz2.open", "lzma.open"})
_WRITING: Final = frozenset("wax+")
_WRITING_METHODS: Final = ("write_text", "write_bytes", "tofile", "savefig")
_UNSEEDED: Final = frozenset({"numpy.random.default_rng", "numpy.random.seed", "numpy.random.RandomState",
                              "random.seed", "random.Random"})  # fmt: skip
"""Generators that start from the entropy of the machine if they get no seed."""
_CLOCKS: Final = re.compile(r"time\.(time|time_ns|perf_counter|monotonic)|os\.urandom|uuid\.uuid4"
                            r"|datetime\.datetime\.(now|today)")  # fmt: skip


@checks_function(Code.NRP243, Code.NRP302, Code.NRP357, Code.NRP378)
def check_effects(function: CheckedFunction) -> Iterator[Finding]:
    """Look for calls that wait, write files, depend on more than the run, or end the process."""
    imported = full_names(function.declared.source.tree)
    roots = {name.partition(".")[0] for name in imported}
    raised = {id(one.exc) for one in function.declared.own if isinstance(one, ast.Raise)}
    for node in function.declared.own:
        match node:
            case ast.Call(called) | ast.Subscript(called):
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
            is_other = effect.code is Code.NRP243 and _is_substitute(function, root)
            is_question = effect.code is Code.NRP302 and _sends_no_signal(node)
            if re.fullmatch(effect.names, name) and not is_other and not is_question:
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


def _sends_no_signal(node: ast.AST) -> bool:
    """Return whether a signal is 0, which only checks whether a process exists."""
    is_call = isinstance(node, ast.Call) and len(node.args) == 2
    return is_call and isinstance(node.args[1], ast.Constant) and node.args[1].value == 0  # type: ignore[attr-defined]


@checks_experiment(Code.NRP243)
def check_seeds_of_brain_script(static: StaticExperiment) -> Iterator[Finding]:
    """Look for what makes a brain script build another network in each run."""
    path = static.experiment.brain.model
    source = next((one for one in static.scripts if one.path == path), None)
    if source is None:
        return
    imported = full_names(source.tree)
    calls = [node for node in ast.walk(source.tree) if isinstance(node, ast.Call)]
    seeds = {inner for call in calls for seed in _seeds(call, imported) for inner in ast.walk(seed)}
    for node in calls:
        name = _full_name(node.func, imported)
        if name in _UNSEEDED and not node.args and not node.keywords:
            message = f"'{excerpt(node)}' has no seed: it is another one in each run"
        elif _CLOCKS.fullmatch(name) and node in seeds:
            message = f"'{excerpt(node)}' is part of a seed and another one in each run"
        else:
            continue
        yield Finding(Code.NRP243, message, Level.WARNING, path, node.lineno, node.col_offset + 1)


def _seeds(call: ast.Call, imported: dict[str, str]) -> Iterable[ast.expr]:
    """Return the arguments of a call that seed something."""
    seeds = [keyword.value for keyword in call.keywords if keyword.arg == "seed"]
    return seeds + (call.args if _full_name(call.func, imported) in _UNSEEDED else [])
