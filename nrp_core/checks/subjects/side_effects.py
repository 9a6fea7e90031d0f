"""State outside variables, files, waiting, and what depends on more than the run."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from types import ModuleType
from typing import Final, NamedTuple

from nrp_core.checks.code.syntax import CHANGING, excerpt, full_names, names_in, own_nodes, root_name, root_of
from nrp_core.checks.code.values import Known, value_of
from nrp_core.checks.static_experiment import CheckedFunction, checks_function
from nrp_core.findings import Code, Finding, Level

_DISPLAYS: Final = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)
_MAKERS: Final = frozenset(
    {"list", "dict", "set", "bytearray", "deque", "defaultdict", "OrderedDict", "Counter", "array", "zeros",
     "ones", "empty", "full", "arange", "linspace", "eye"}
)  # fmt: skip
"""Functions and classes that return a container or an array, by the last part of their name."""


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
_WHOLE: Final = (":", "...")
_WRITING: Final = frozenset("wax+")
_WRITING_METHODS: Final = ("write_text", "write_bytes", "tofile", "savefig")


@checks_function
def check_state(function: CheckedFunction) -> Iterator[Finding]:
    """Look for globals and for objects of the file that a function changes."""
    skipped = {*_loaded_once(function), *_replaced(function)}
    found: set[str] = set()
    for name, node in _changes(function, _mutable_objects(function.declared.source.tree)):
        if id(node) not in skipped and name not in found:
            found.add(name)
            message = f"no reset and no snapshot restores '{name}': keep what changes in a MapVariable"
            yield function.warning(Code.NRP301, node, message)


def _mutable_objects(tree: ast.Module) -> set[str]:
    """Return the names of objects of a file whose contents or attributes may change."""
    found: set[str] = set()
    classes = {node.name for node in own_nodes(tree.body) if isinstance(node, ast.ClassDef)}
    for node in own_nodes(tree.body):
        match node:
            case ast.Assign([ast.Name(name)], value) | ast.AnnAssign(ast.Name(name), _, ast.expr() as value):
                made = value.func if isinstance(value, ast.Call) else None
                maker = made.attr if isinstance(made, ast.Attribute) else getattr(made, "id", "")
                if isinstance(value, _DISPLAYS) or maker in _MAKERS | classes:
                    found.add(name)
            case ast.FunctionDef(name=name, decorator_list=[]) | ast.ClassDef(name=name):
                found.add(name)
    return found


def _changes(function: CheckedFunction, objects: set[str]) -> Iterator[tuple[str, ast.AST]]:
    """Yield what a function sets of globals, enclosing functions and modules, and the objects it changes."""
    own = function.declared.own
    shared = {name for one in own if isinstance(one, ast.Global | ast.Nonlocal) for name in one.names}
    objects = {name for name in objects if not function.body.is_local(name)}
    for node in reversed(own):
        match node:
            case ast.Name(name, ast.Store() | ast.Del()) if name in shared:
                yield name, node
            case ast.Attribute(value, ctx=ast.Store()) if value_of(function.body.shape(value), ModuleType):
                yield ast.unparse(node), node
            case ast.Call(ast.Attribute(owner, method)) if method in CHANGING and root_name(owner) in objects:
                yield root_name(owner), node
            case ast.Attribute(ctx=context) | ast.Subscript(ctx=context) if root_name(node) in objects:
                if not isinstance(context, ast.Load):
                    yield root_name(node), node


def _replaced(function: CheckedFunction) -> Iterator[int]:
    """Yield the targets of ``x[:] = ...``, which replaces all old values."""
    for node in function.declared.own:
        match node:
            case ast.Assign([ast.Subscript(owner, part) as target], value) if ast.unparse(part) in _WHOLE:
                if all(ast.unparse(one) != ast.unparse(owner) for one in ast.walk(value)):
                    yield id(target)


def _loaded_once(function: CheckedFunction) -> Iterator[int]:
    """Yield the targets of ``if x is None: x = load()``: the value is the same after a reset."""
    for branch in (one for one in function.declared.own if isinstance(one, ast.If)):
        for node in branch.body:
            match node:
                case ast.Assign([target], value) if any(isinstance(one, ast.Call) for one in ast.walk(value)):
                    if root_name(target) in names_in(branch.test):
                        yield from (id(target), id(root_of(target)))


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
