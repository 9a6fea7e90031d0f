"""State that a reset or snapshot leaves, and files that a replay writes again."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from types import ModuleType

from nrp_core.checks.code.declarations import Function, local_names, root_of, used_functions
from nrp_core.checks.code.shapes import Known, Names, Write, full_names
from nrp_core.checks.code.statements import CHANGING
from nrp_core.checks.code.syntax import excerpt, own_nodes
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.mappings import MapCSVRecorder
from nrp_core.findings import Code, Finding, Level

_OPENERS = frozenset({"open", "io.open", "codecs.open", "gzip.open", "bz2.open", "lzma.open"})
_SAVERS = frozenset(
    {"numpy.save", "numpy.savez", "numpy.savez_compressed", "numpy.savetxt", "scipy.io.savemat", "torch.save",
     "cv2.imwrite", "joblib.dump"}
)  # fmt: skip
_METHODS = frozenset({"write_text", "write_bytes", "tofile", "savefig"})
"""Methods that only write files."""
_TABLES = frozenset({"to_csv", "to_excel", "to_hdf", "to_pickle", "to_parquet", "to_feather"})
"""Methods of tables that write a file if they get a first argument."""
_IN_MEMORY = frozenset({"BytesIO", "StringIO"})
_WRITING = frozenset("wax+")


@checks_function(Code.NRP301)
def files_are_left_to_recorders(function: CheckedFunction) -> Iterator[Finding]:
    """Look for calls that write a file."""
    imported = full_names(function.declared.source.tree)
    for used in used_functions(function.declared):
        own = local_names(used)
        if any(getattr(one, "attr", getattr(one, "id", "")) in _IN_MEMORY for one in ast.walk(used)):
            continue
        for node in ast.walk(used):
            if isinstance(node, ast.Call) and _writes(node, own, imported):
                name = excerpt(node)
                message = (
                    f"'{name}' writes a file, which reset, replay and confined runs do not handle: "
                    "record values with the CSV recorder (nrp.MapCSVRecorder)"
                )
                yield function.declared.finding(Code.NRP301, node, message, Level.WARNING)


@checks_experiment(Code.NRP240)
def recorders_of_one_file_have_the_same_columns(static: StaticExperiment) -> Iterator[Finding]:
    """Look for two recorders with different headers whose rows go into one file."""
    first: dict[object, tuple[str, list[str]]] = {}
    for function in static.functions:
        for name, mapping in function.function.mappings.items():
            if not isinstance(mapping, MapCSVRecorder):
                continue
            headers = list(mapping.headers)
            owner, others = first.setdefault(mapping.filename, (function.function.name, headers))
            if headers != others:
                message = (
                    f"the rows of '{name}' have the columns {', '.join(headers)}, and go below those of "
                    f"'{owner}' in '{mapping.filename}', which are {', '.join(others)}"
                )
                node = function.declared.nodes.get(name)
                yield function.declared.finding(Code.NRP240, node, message, Level.WARNING)


def _writes(call: ast.Call, own: set[str], imported: dict[str, str]) -> bool:
    """Return whether a call certainly writes a file."""
    root, dot, rest = ast.unparse(call.func).partition(".")
    called = "" if root in own else imported.get(root, root) + dot + rest
    if called in _OPENERS:
        return _is_for_writing(call, 1)
    if called in _SAVERS:
        return True
    if not isinstance(call.func, ast.Attribute):
        return False
    method = call.func.attr
    if method == "open" and not called.startswith(("os.", "webbrowser.")):
        return _is_for_writing(call, 0)
    return method in _METHODS or (method in _TABLES and bool(call.args))


def _is_for_writing(call: ast.Call, index: int) -> bool:
    """Return whether the mode of an opened file, the argument at ``index``, allows to write."""
    given = [keyword.value for keyword in call.keywords if keyword.arg == "mode"] or call.args[index:][:1]
    mode = given[0].value if given and isinstance(given[0], ast.Constant) else None
    return isinstance(mode, str) and len(mode) < 5 and bool(_WRITING & set(mode))


_DISPLAYS = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)
_MAKERS = frozenset(
    {"list", "dict", "set", "bytearray", "deque", "defaultdict", "OrderedDict", "Counter", "array", "zeros",
     "ones", "empty", "full", "arange", "linspace", "eye"}
)  # fmt: skip
"""Functions and classes that return a container or an array, by the last part of their name."""


@checks_function(Code.NRP301)
def state_is_in_variables(function: CheckedFunction) -> Iterator[Finding]:
    """Look for globals, objects of the file and default values that functions change."""
    kept = _kept_in(function.declared.source.tree)
    functions = list(used_functions(function.declared))
    messages = set(_messages_in(function))
    for used in functions:
        found: dict[str, ast.AST] = {}
        summed = _summed(used, messages - local_names(used))
        for name, node in (*_rebound(used), *_changed(used, kept), *_defaults(used, functions), *summed):
            found.setdefault(name, node)
        for name, node in found.items():
            yield _finding(function, name, node)


@checks_function(Code.NRP301)
def modules_stay_as_they_are(function: CheckedFunction) -> Iterator[Finding]:
    """Look for names of modules that a function sets."""
    for event in function.events:
        if isinstance(event, Write) and _is_module(event.owner):
            yield _finding(function, ast.unparse(event.node), event.node)


def _finding(function: CheckedFunction, name: str, node: ast.AST) -> Finding:
    message = f"no reset and no snapshot restores '{name}': keep what changes in a MapVariable"
    return function.declared.finding(Code.NRP301, node, message, Level.WARNING)


def _is_module(owner: object) -> bool:
    return isinstance(owner, Names) or (isinstance(owner, Known) and isinstance(owner.value, ModuleType))


def _kept_in(tree: ast.Module) -> dict[str, frozenset[str]]:
    """Return the names of mutable objects in a file, with the methods that change them."""
    nodes = list(own_nodes(tree.body))
    classes = {node.name: _changing_methods(node) for node in nodes if isinstance(node, ast.ClassDef)}
    found = {name: frozenset[str]() for name in classes}
    for node in nodes:
        match node:
            case ast.Assign([ast.Name(name)], value) | ast.AnnAssign(ast.Name(name), _, ast.expr() as value):
                if isinstance(value, _DISPLAYS) or _maker(value) in _MAKERS:
                    found[name] = CHANGING
                elif _maker(value) in classes:
                    found[name] = classes[_maker(value)]
            case ast.FunctionDef(name=name, decorator_list=[]):
                found[name] = frozenset()
    return found


def _changing_methods(node: ast.ClassDef) -> frozenset[str]:
    """Return the methods of a class that change their object."""
    methods = [one for one in node.body if isinstance(one, ast.FunctionDef) and one.args.args]
    return frozenset(
        method.name
        for method in methods
        if any(root.id == method.args.args[0].arg and not called for root, _, called in _changes(method))
    )


def _maker(value: ast.expr) -> str:
    """Return the last part of the name of the function or class that creates a value."""
    match value:
        case ast.Call(ast.Name(name)) | ast.Call(ast.Attribute(attr=name)):
            return name
    return ""


def _rebound(function: Function) -> Iterator[tuple[str, ast.AST]]:
    """Yield the global names, and those of an enclosing function, that a function sets."""
    shared = {
        name
        for nodes, kind in ((ast.walk(function), ast.Global), (own_nodes(function.body), ast.Nonlocal))
        for node in nodes
        if isinstance(node, kind)
        for name in node.names
    }
    once = set(_made_once(function))
    for node in ast.walk(function):
        match node:
            case ast.Name(name, ast.Store() | ast.Del()) if name in shared and id(node) not in once:
                yield name, node


def _made_once(function: Function) -> Iterator[int]:
    """Yield the targets of ``if x is None: x = load()``: the value is the same after a reset."""
    own = local_names(function)
    for node in ast.walk(function):
        match node:
            case ast.If(test, body):
                asked = _names(test)
            case ast.Try(body=tried, handlers=[ast.ExceptHandler(body=body)]):
                asked = _names(ast.Module(tried, []))
            case _:
                continue
        for statement in body:
            match statement:
                case ast.Assign([target], value) if _has_call(value):
                    root = root_of(target)
                    named = isinstance(root, ast.Name) and root.id in asked
                    if named and (root is not target or not _names(value) & own):
                        yield id(root)


def _has_call(value: ast.expr) -> bool:
    return any(isinstance(one, ast.Call) for one in ast.walk(value))


def _names(node: ast.AST) -> set[str]:
    return {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}


def _changed(function: Function, kept: Mapping[str, frozenset[str]]) -> Iterator[tuple[str, ast.AST]]:
    """Yield the objects of a file that a function changes in place."""
    once, own = set(_made_once(function)), local_names(function)
    for root, node, method in _changes(function):
        is_kept = root.id in kept.keys() - own and id(root) not in once
        if is_kept and (not method or method in kept[root.id]):
            yield root.id, node


def _messages_in(function: CheckedFunction) -> Iterator[str]:
    """Yield the names of messages that the file of a function makes once."""
    for node in function.declared.source.tree.body:
        match node:
            case ast.Assign([ast.Name(name)], ast.Call(ast.Name(maker))):
                shape = function.declared.names.get(maker)
                if isinstance(shape, Known) and hasattr(shape.value, "__msgtype__"):
                    yield name
            case ast.Assign([ast.Name(name)], ast.Call(ast.Attribute(ast.Attribute(package, "msg")))):
                if ast.unparse(package).endswith("_msgs"):
                    yield name


def _summed(function: Function, messages: set[str]) -> Iterator[tuple[str, ast.AST]]:
    """Yield the messages of a file to which a function adds; it may fill one anew in each call."""
    begun = {
        f"{ast.unparse(target)}.": one.lineno
        for one in reversed(function.body)
        if isinstance(one, ast.Assign)
        for target in one.targets
    }
    for node in own_nodes(function.body):
        match node:
            case ast.AugAssign(ast.Attribute() as target):
                root, where = root_of(target), f"{ast.unparse(target)}."
                is_new = any(where.startswith(each) and line < node.lineno for each, line in begun.items())
                if isinstance(root, ast.Name) and root.id in messages and not is_new:
                    yield root.id, node


def _changes(function: Function) -> Iterator[tuple[ast.Name, ast.expr, str]]:
    """Yield the objects that a function may change in place, with the called method, if any.

    ``x[:] = ...`` is left out: it replaces all old values.
    """
    replaced = {
        id(target)
        for node in ast.walk(function)
        if isinstance(node, ast.Assign)
        for target in node.targets
        if _is_whole(target) and not _names(target) & _names(node.value)
    }
    for node in ast.walk(function):
        match node:
            case ast.Call(ast.Name() as root):
                yield root, node, "__call__"
            case ast.Call(ast.Attribute(ast.Name() as root, method)):
                yield root, node, method
            case ast.Call(ast.Attribute(owner, method)) if method in CHANGING:
                if isinstance(owner := root_of(owner), ast.Name):
                    yield owner, node, ""
            case ast.Attribute(ctx=ast.Store() | ast.Del()) | ast.Subscript(ctx=ast.Store() | ast.Del()):
                if isinstance(owner := root_of(node), ast.Name) and id(node) not in replaced:
                    yield owner, node, ""


def _is_whole(target: ast.expr) -> bool:
    """Return whether an assignment is to ``x[:]`` or ``x[...]``."""
    return isinstance(target, ast.Subscript) and ast.unparse(target.slice) in (":", "...")


def _defaults(function: Function, functions: list[Function]) -> Iterator[tuple[str, ast.AST]]:
    """Yield the default values that a function changes if a call does not give the argument."""
    mutable = _mutable_defaults(function)
    changed = {root.id for root, _, method in _changes(function) if not method or method in CHANGING}
    calls = [
        node
        for one in functions
        for node in ast.walk(one)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == function.name
    ]
    for name, (index, default) in mutable.items():
        if name in changed and any(not _gives(call, name, index) for call in calls):
            yield name, default


def _mutable_defaults(function: Function) -> Mapping[str, tuple[int, ast.expr]]:
    """Return the mutable default values: the parameter, its index and its default."""
    arguments = [*function.args.posonlyargs, *function.args.args]
    first = len(arguments) - len(function.args.defaults)
    found = {arguments[i].arg: (i, value) for i, value in enumerate(function.args.defaults, start=first)}
    for one, value in zip(function.args.kwonlyargs, function.args.kw_defaults, strict=True):
        if value is not None:
            found[one.arg] = len(arguments), value
    return {
        name: (i, value)
        for name, (i, value) in found.items()
        if isinstance(value, _DISPLAYS) or _maker(value) in _MAKERS
    }


def _gives(call: ast.Call, name: str, index: int) -> bool:
    """Return whether a call may give the argument."""
    unclear = any(isinstance(one, ast.Starred) for one in call.args) or len(call.args) > index
    return unclear or any(keyword.arg in (name, None) for keyword in call.keywords)
