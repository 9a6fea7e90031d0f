"""Read the parameters that a script declares, without executing it."""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from nrp_core.errors import ExperimentError, ParameterError
from nrp_core.parameters.parameter import Parameter
from nrp_core.registry import Registry
from nrp_core.scripts import last_name

CALL = "parameter"
_ARGUMENTS = ("name", "default")
_OPTIONS = ("unit", "low", "high", "doc")
_LOOKING = frozenset({"globals", "locals", "vars", "exec", "eval"})
"""Functions with which a script may read names that it does not write."""


@dataclass(frozen=True, slots=True)
class DeclarationStyle:
    """How a kind of script names the object whose ``parameter`` declares one.

    Args:
        name: its usual name, also as an argument of functions.
        packages: the packages that it is imported from.
        makers: functions that return it first.
        plugins: an entry-point group whose plugins are named after further modules that it is imported from.
    """

    name: str
    packages: frozenset[str]
    makers: frozenset[str] = frozenset()
    plugins: str = ""

    def has(self, module: str) -> bool:
        """Return whether the object may be imported from a module."""
        added = Registry[object](self.plugins, "plugin").names() if self.plugins else ()
        return module.partition(".")[0] in self.packages | {name.partition(".")[0] for name in added}


BRAIN = DeclarationStyle(
    "sim",
    frozenset({"nrp_core", "pyNN"}),
    frozenset({"get_simulator"}),
    "nrp_core.pynn_dialects",
)
FUNCTIONS = DeclarationStyle("nrp", frozenset({"nrp_core", "hbp_nrp_client"}))


@dataclass(slots=True)
class Declared:
    """The parameters of a script and of the modules that it imports from its folder.

    Args:
        parameters: by name, in the order of the script.
        mistakes: declarations that cannot be read, or contradict themselves or another.
        trees: the files of the script.
    """

    parameters: dict[str, Parameter] = field(default_factory=dict)
    mistakes: list[ExperimentError] = field(default_factory=list)
    trees: dict[Path, ast.Module] = field(default_factory=dict)

    def add(self, parameter: Parameter) -> None:
        """Add a parameter; one of a known name must be the same."""
        known = self.parameters.setdefault(parameter.name, parameter)
        if known != parameter:
            message = (
                f"parameter '{parameter.name}' is declared with other arguments at {known.place}; "
                "make the two equal, or rename one"
            )
            self.mistakes.append(ParameterError(message, path=parameter.path, line=parameter.line))

    @property
    def unused(self) -> list[Parameter]:
        """The parameters declared at the top of a file, and kept under no name or one that no file reads.

        A script that looks names up (``globals()``, ``exec``) may read any of them.
        """
        if not self.parameters:
            return []
        nodes = [node for tree in self.trees.values() for node in _nodes(tree)]
        read = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
        if read & _LOOKING:
            return []
        for node in nodes:
            match node:
                case ast.Attribute(attr=name):
                    read.add(name)
                case ast.ImportFrom(names=names):
                    read |= {one.name for one in names}
        kept_nowhere = {
            (path, statement.lineno)
            for path, tree in self.trees.items()
            for i, statement in enumerate(tree.body)
            if _is_discarded(statement, read) or i in _replaced(tree)
        }
        return [one for one in self.parameters.values() if (one.path, one.line) in kept_nowhere]


def parse_script(path: Path) -> ast.Module:
    """Return a file of Python as a tree.

    Raises:
        SyntaxError, ValueError, OSError: it is not Python, or cannot be read.
    """
    return _parse(path.read_bytes())


@lru_cache(maxsize=64)
def _parse(data: bytes) -> ast.Module:
    """Return a script as a tree, which must not be changed: the runs of a sweep share it."""
    return ast.parse(data)


@lru_cache(maxsize=64)
def _nodes(tree: ast.Module) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(tree))


def read_parameters(
    path: Path,
    dialect: DeclarationStyle,
    tree_of: Callable[[Path], ast.Module] = parse_script,
    into: Declared | None = None,
) -> Declared:
    """Return the parameters that a script declares; a file that is not Python has none.

    Args:
        path: the script.
        dialect: which kind of script it is.
        tree_of: reads a file.
        into: the declarations of other scripts.
    """
    declared = into or Declared()
    waiting, seen = [path], set[Path]()
    while waiting:
        file = waiting.pop(0)
        if file in seen or file.suffix != ".py" or not file.is_file():
            continue
        seen.add(file)
        try:
            tree = tree_of(file)
        except (SyntaxError, ValueError, OSError):  # reported where the script is executed or checked
            continue
        declared.trees[file] = tree
        nodes = _nodes(tree)
        for call in _calls(nodes, dialect):
            _declare(call, file, declared)
        waiting += _neighbours(nodes, file.parent)
    return declared


def read_in_groups(files: Mapping[str, Path], read: Callable[[Path], Declared]) -> Declared:
    """Return the parameters of several scripts, those of ``red`` as ``red.gain``; ``""`` adds no name."""
    declared = Declared()
    for group, path in files.items():
        own = read(path)
        declared.mistakes += own.mistakes
        declared.trees |= own.trees
        for name, one in own.parameters.items():
            declared.parameters[f"{group}.{name}" if group else name] = one
    return declared


def _declare(call: ast.Call, path: Path, declared: Declared) -> None:
    try:
        declared.add(_parameter(call, path))
    except ExperimentError as error:
        declared.mistakes.append(error)


def _parameter(call: ast.Call, path: Path) -> Parameter:
    def wrong(node: ast.AST, message: str) -> ExperimentError:
        return ExperimentError(message, path=path, line=getattr(node, "lineno", call.lineno))

    known = (*_ARGUMENTS, *_OPTIONS)
    if len(call.args) > len(_ARGUMENTS) or any(isinstance(one, ast.Starred) for one in call.args):
        raise wrong(call, f"{CALL}() takes {', '.join(_ARGUMENTS)}, and by name {', '.join(_OPTIONS)}")
    given = dict(zip(_ARGUMENTS, call.args, strict=False))
    for keyword in call.keywords:
        if keyword.arg is None or keyword.arg not in known or keyword.arg in given:
            raise wrong(keyword, f"{CALL}() takes {', '.join(known)}, each once, not '{keyword.arg or '**'}'")
        given[keyword.arg] = keyword.value
    if missing := [name for name in _ARGUMENTS if name not in given]:
        raise wrong(call, f"{CALL}() needs {' and '.join(missing)}")
    values = {}
    for name, node in given.items():
        try:
            values[name] = ast.literal_eval(node)
        except (ValueError, TypeError, MemoryError, RecursionError):
            message = (
                f"the {name} of a parameter must be a literal, not '{ast.unparse(node)}': parameters are "
                "checked without executing the file"
            )
            raise wrong(node, message) from None
    for name, kind in (("name", str), ("unit", (str, type(None))), ("doc", str)):
        if name in values and not isinstance(values[name], kind):
            raise wrong(given[name], f"the {name} of a parameter must be a text, not {values[name]!r}")
    return Parameter(**values, path=path, line=call.lineno)


def _calls(nodes: Collection[ast.AST], dialect: DeclarationStyle) -> Iterator[ast.Call]:
    """Yield the calls that declare parameters."""
    objects, functions = {dialect.name}, set[str]()
    for node in nodes:
        match node:
            case ast.Import(names):
                objects |= {one.asname or one.name for one in names if dialect.has(one.name)}
            case ast.ImportFrom(module=str(module), names=names) if dialect.has(module):
                functions |= {one.asname or one.name for one in names if one.name == CALL}
                objects |= {one.asname or one.name for one in names if one.name != CALL}
            case ast.Assign(targets=[target], value=ast.Call(func=func)) if last_name(func) in dialect.makers:
                first = target.elts[0] if isinstance(target, ast.Tuple) else target
                objects.add(ast.unparse(first))
    for node in nodes:
        match node:
            case ast.Call(func=ast.Attribute(value=of, attr="parameter")) if ast.unparse(of) in objects:
                yield node
            case ast.Call(func=ast.Name(id=name)) if name in functions:
                yield node


def _is_discarded(node: ast.stmt, read: Collection[str]) -> bool:
    """Return whether a statement drops a parameter's value, or assigns it to a name that nothing reads."""
    match node:
        case ast.Expr(ast.Call(func)):
            return last_name(func) == CALL
        case ast.Assign([ast.Name(name)], ast.Call(func)) | ast.AnnAssign(ast.Name(name), _, ast.Call(func)):
            return last_name(func) == CALL and name not in read
    return False


@lru_cache(maxsize=64)
def _replaced(tree: ast.Module) -> frozenset[int]:
    return frozenset(i for i in range(len(tree.body)) if _is_replaced(tree.body, i))


def _is_replaced(statements: Sequence[ast.stmt], i: int) -> bool:
    """Return whether a statement assigns a parameter to a name that is overwritten before it is read."""
    match statements[i]:
        case ast.Assign([ast.Name(name)], ast.Call(func)) if last_name(func) == CALL:
            mentions = [
                (j, [one.ctx for one in ast.walk(statement) if isinstance(one, ast.Name) and one.id == name])
                for j, statement in enumerate(statements)
                if j != i
            ]
            first, contexts = next(((j, contexts) for j, contexts in mentions if contexts), (0, []))
            is_set = len(contexts) == 1 and isinstance(contexts[0], ast.Store)
            return first > i and is_set and isinstance(statements[first], ast.Assign)
    return False


def _neighbours(nodes: Collection[ast.AST], folder: Path) -> Iterator[Path]:
    for node in nodes:
        names: list[str] = []
        match node:
            case ast.Import(aliases):
                names = [one.name for one in aliases]
            case ast.ImportFrom(module=str(module), names=aliases):
                names = [module, *(f"{module}.{one.name}" for one in aliases)]
        for name in names:
            yield folder / f"{name.replace('.', '/')}.py"
