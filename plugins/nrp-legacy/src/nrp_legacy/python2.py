"""Convert Python 2 to Python 3.

Only code that Python 3 refuses is rewritten; methods, results and indices that Python 3 and today's libraries
have dropped are replaced in all code.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from nrp_core.errors import TransferFunctionError
from nrp_core.scripts import unbound_names
from nrp_legacy import python2_builtins
from nrp_legacy.python2_text import rewritten as _rewritten

ROUND = "_round_of_python_2"
INDEX = "_index_of_numpy_1"
HELPERS = {
    "_next_of_python_2": "next_of", "_sort_of_python_2": "sort", "_text_of_python_2": "text_of",
    "_message_of_python_2": "message_of", "_bytes_of_numpy_1": "bytes_of", "_ptp_of_numpy_1": "ptp_of",
    "_itemset_of_numpy_1": "itemset_of", "_rgb_of_matplotlib_1": "rgb_of",
    ROUND: "round_of", INDEX: "index_of",
}  # fmt: skip
"""The names under which converted code finds functions of :mod:`nrp_legacy.python2_builtins`."""
_NAMES = {function: name for name, function in HELPERS.items()}
_FUNCTIONS = {"ptp": "ptp_of", "itemset": "itemset_of"}
_FUNCTIONS_OF_NOTHING = {"next": "next_of", "tostring": "bytes_of", "tostring_rgb": "rgb_of"}
"""Methods that functions stand for: with any values, and without one."""
_METHODS = {
    "iteritems": "items", "itervalues": "values", "iterkeys": "keys",
    "viewitems": "items", "viewvalues": "values", "viewkeys": "keys",
}  # fmt: skip
_VIEWS = ("keys", "values", "items")
_SPECIAL = {
    "__nonzero__": "__bool__",
    "next": "__next__",
    "__div__": "__truediv__",
    "__rdiv__": "__rtruediv__",
}
_COMPARISONS = {"__lt__": "<", "__le__": "<=", "__gt__": ">", "__ge__": ">=", "__eq__": "=="}
_IMAGE_FIRST = 3  # results of cv2.findContours in OpenCV 3


class Outdated(ast.NodeTransformer):
    """Replaces removed methods and results.

    Args:
        changes: receives each change for Python 2.
        is_old: whether the code is of Python 2 for certain: texts are bytes there, too.
    """

    def __init__(self, changes: list[str], *, is_old: bool) -> None:
        self._changes, self._is_old = changes, is_old

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.func, ast.Attribute):
            return self._method_called(node, node.func)
        if self._is_old and isinstance(node.func, ast.Name) and node.func.id == "round" and node.args:
            self._changes.append("round()")
            return call(ROUND, node, *node.args, keywords=node.keywords)
        return node

    def _method_called(self, node: ast.Call, method: ast.Attribute) -> ast.AST:
        name = method.attr
        if name in _METHODS and not node.args:
            self._changes.append(f"{name}()")
            method.attr = _METHODS[name]
            return node
        if name == "has_key" and len(node.args) == 1:
            self._changes.append("has_key()")
            return ast.copy_location(ast.Compare(node.args[0], [ast.In()], [method.value]), node)
        function = self._function_for(name, node)
        if function is not None:
            return call(_NAMES[function], node, method.value, *node.args, keywords=node.keywords)
        return call("list", node, node) if _is_view(node) else node

    def _function_for(self, method: str, node: ast.Call) -> str | None:
        """Return the function that replaces a method call, if any."""
        if method == "sort" and (node.args or any(one.arg == "cmp" for one in node.keywords)):
            return "sort"
        if self._is_old and method in ("encode", "decode"):
            return "text_of"
        is_bare = not node.args and not node.keywords
        return _FUNCTIONS.get(method) or (_FUNCTIONS_OF_NOTHING.get(method) if is_bare else None)

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        if _is_view(node.value):
            self._changes.append("indices of dictionary views")
        self.generic_visit(node)
        return node

    def visit_ExceptHandler(self, node: ast.ExceptHandler) -> ast.AST:
        self.generic_visit(node)
        return _Messages(node.name).visit(node) if node.name else node

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        self.generic_visit(node)
        own = {one.name for one in node.body if isinstance(one, ast.FunctionDef)}
        lines = [f"{new} = {old}" for old, new in _SPECIAL.items() if old in own and new not in own]
        if "__cmp__" in own and "__lt__" not in own:
            lines += [
                f"{name} = lambda self, other: self.__cmp__(other) {sign} 0"
                for name, sign in _COMPARISONS.items()
            ]
        node.body += [ast.copy_location(one, node.body[-1]) for one in ast.parse("\n".join(lines)).body]
        return node

    def visit_Assign(self, node: ast.Assign) -> ast.AST:
        self.generic_visit(node)
        target, result = node.targets[0], node.value
        if (
            isinstance(target, ast.Tuple) and len(target.elts) == _IMAGE_FIRST
            and isinstance(result, ast.Call) and isinstance(result.func, ast.Attribute)
            and result.func.attr == "findContours" and result.args
        ):  # fmt: skip
            self._changes.append("three results of findContours")
            results = [result.args[0], ast.Starred(result, ast.Load())]
            node.value = ast.copy_location(ast.Tuple(results, ast.Load()), result)
        return node


class _Messages(ast.NodeTransformer):
    """Adds ``message`` to the error of a handler.

    Args:
        error: its name.
    """

    def __init__(self, error: str) -> None:
        self._error = error

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        self.generic_visit(node)
        is_error = isinstance(node.value, ast.Name) and node.value.id == self._error
        return call(_NAMES["message_of"], node, node.value) if is_error and node.attr == "message" else node


def call(
    function: str, place: ast.AST, *values: ast.expr, keywords: list[ast.keyword] | None = None
) -> ast.Call:
    """Return the call of a function with the place of another node."""
    return ast.copy_location(ast.Call(ast.Name(function, ast.Load()), [*values], keywords or []), place)


def _is_view(node: ast.expr) -> bool:
    return (
        isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in _VIEWS
        and not node.args and not node.keywords
    )  # fmt: skip


class Indices(ast.NodeTransformer):
    """Wraps each index that may be one of them; decorators, which name populations, stay unchanged."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.body = [self.visit(statement) for statement in node.body]
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        self.generic_visit(node)
        node.slice = _wrapped(node.slice)
        return node


def _wrapped(index: ast.expr) -> ast.expr:
    match index:
        case ast.Tuple(elements):
            index.elts = [_wrapped(element) for element in elements]
        case ast.Slice(lower, upper, step):
            index.lower, index.upper, index.step = (one and _wrapped(one) for one in (lower, upper, step))
        case ast.Constant(value) | ast.UnaryOp(operand=ast.Constant(value)) if not isinstance(value, float):
            pass
        case ast.JoinedStr() | ast.Starred():
            pass
        case _:
            return call(INDEX, index, index)
    return index


DIVIDE = "_divide_of_python_2"
"""The name under which converted code finds :func:`nrp_legacy.python2_builtins.divide`."""

_QUOTIENT, _ORDER = "_quotient", "_compared_as_in_python_2"
_OF_ONE = {"float": "_float_of_one", "int": "_int_of_one"}
_ALIASES = {
    DIVIDE: "divide", _QUOTIENT: "quotient", _OF_ONE["float"]: "float_of", _OF_ONE["int"]: "int_of",
    _ORDER: "compared", **HELPERS,
}  # fmt: skip


def names() -> dict[str, object]:
    """Return the built-in functions of Python 2 that Python 3 lacks or has changed."""
    aliases = {name: name for name in python2_builtins.__all__} | _ALIASES
    return {name: getattr(python2_builtins, meant) for name, meant in aliases.items()}


@dataclass(frozen=True, slots=True)
class Converted:
    """Code for Python 3.

    Args:
        tree: its syntax tree, with the line numbers of the original.
        changes: short descriptions of the changes.
        divides_truly: whether ``/`` certainly has the meaning of Python 3.
    """

    tree: ast.Module
    changes: tuple[str, ...]
    divides_truly: bool = False


def converted(code: str) -> Converted:
    """Return the syntax tree of code that may be Python 2.

    Raises:
        SyntaxError: it is neither Python 3 nor Python 2 that can be converted.
    """
    changes: list[str] = []
    tree, _ = _parsed(code)
    is_old = tree is None or _is_certainly_old(tree)
    if is_old:
        text, changes = _rewritten(code)
        tree, refused = _parsed(text)
        if tree is None:
            raise refused or SyntaxError("not converted")
        if not _divides_truly(tree):
            tree = _Division(DIVIDE, changes).visit(tree)
    assert tree is not None
    for scope, names in list(_late_globals(tree)):
        changes.append("global after use")
        _declare_first(scope, names)
    tree = Outdated(changes, is_old=is_old).visit(tree)
    done = is_old or _divides_truly(tree)
    return Converted(ast.fix_missing_locations(tree), tuple(dict.fromkeys(changes)), done)


def executable(code: Converted) -> ast.Module:
    """Return code that imports the functions of Python 2 it needs, and whose quotients can be indices."""
    tree = code.tree
    divisions = () if code.divides_truly else (_Division(_QUOTIENT, []),)
    for transformer in (*divisions, _Numbers(), _Order(), Indices()):
        tree = transformer.visit(tree)
    loaded = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    bound = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and _is_bound(node)}
    bound |= {node.name for node in ast.walk(tree) if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    wanted = sorted((loaded - bound) & {*python2_builtins.__all__, *_ALIASES})
    if wanted:
        aliases = [ast.alias(_ALIASES.get(name, name), name) for name in wanted]
        tree.body.insert(_first_place(tree), ast.ImportFrom(python2_builtins.__name__, aliases, 0))
    return ast.fix_missing_locations(tree)


def rewritten(code: str) -> str:
    """Return code as text for Python 3; divisions and methods stay unchanged."""
    return _rewritten(code)[0]


def _is_bound(node: ast.Name) -> bool:
    return not isinstance(node.ctx, ast.Load)


def _first_place(tree: ast.Module) -> int:
    """Return the place for a first statement: after the docstring and ``from __future__``."""
    place = int(ast.get_docstring(tree) is not None)
    while place < len(tree.body) and getattr(tree.body[place], "module", "") == "__future__":
        place += 1
    return place


def _parsed(code: str) -> tuple[ast.Module | None, SyntaxError | None]:
    try:
        return ast.parse(code), None
    except SyntaxError as error:
        return None, error


def uses_python_2(code: str) -> bool:
    """Return whether code that Python 3 can parse uses features of Python 2 alone."""
    return _is_certainly_old(ast.parse(code))


def _is_certainly_old(tree: ast.Module) -> bool:
    if any(map(_is_print_statement, ast.walk(tree))) or any(_late_globals(tree)):
        return True
    removed = _REMOVED & unbound_names(tree)
    both = {id(name) for node in ast.walk(tree) if _is_for_both(node) for name in ast.walk(node)}
    names = (node for node in ast.walk(tree) if isinstance(node, ast.Name) and node.id in removed)
    return any(id(name) not in both for name in names)


_Scope = ast.Module | ast.FunctionDef
_SCOPES = (ast.FunctionDef, ast.ClassDef, ast.Lambda)


def _late_globals(tree: ast.Module) -> Iterator[tuple[_Scope, list[str]]]:
    """Yield each scope that declares a global name after its use, with all names that it declares."""
    for scope in ast.walk(tree):
        if not isinstance(scope, _Scope):
            continue
        declared: list[str] = []
        used: set[str] = set()
        is_late = False
        for node in _within(scope):
            if isinstance(node, ast.Global):
                is_late = is_late or not used.isdisjoint(node.names)
                declared += node.names
            used.update(_named(node))
        if is_late:
            yield scope, list(dict.fromkeys(declared))


def _within(parent: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a scope in their order, without those of scopes within it."""
    for node in ast.iter_child_nodes(parent):
        yield node
        if not isinstance(node, _SCOPES):
            yield from _within(node)


def _named(node: ast.AST) -> tuple[str, ...]:
    match node:
        case ast.Name(id=name) | ast.FunctionDef(name=name) | ast.ClassDef(name=name):
            return (name,)
        case ast.ExceptHandler(name=str(name)):
            return (name,)
        case ast.alias(name=name, asname=other):
            return ((other or name).partition(".")[0],)
    return ()


def _declare_first(scope: _Scope, names: list[str]) -> None:
    """Declare the global names of a scope before anything else in it."""
    for node in (scope, *(one for one in _within(scope) if not isinstance(one, _SCOPES))):
        for field, value in ast.iter_fields(node):
            if isinstance(value, list) and any(isinstance(one, ast.Global) for one in value):
                setattr(node, field, [_nothing_for(one) for one in value])
    first = ast.copy_location(ast.Global(names), scope.body[0])
    place = _first_place(scope) if isinstance(scope, ast.Module) else ast.get_docstring(scope) is not None
    scope.body.insert(int(place), first)


def _nothing_for(statement: Any) -> Any:
    is_declaration = isinstance(statement, ast.Global)
    return ast.copy_location(ast.Pass(), statement) if is_declaration else statement


_REMOVED = frozenset({"xrange", "raw_input", "unicode", "basestring", "unichr", "execfile"})
"""Functions that Python 3 does not have under any meaning."""
_VERSIONS = frozenset({"version_info", "version", "hexversion", "PY2", "PY3"})


def _is_for_both(node: ast.AST) -> bool:
    """Return whether code asks for the version of Python, or tries a name that may be missing."""
    match node:
        case ast.If(test=test) | ast.IfExp(test=test):
            asked = {getattr(part, "attr", getattr(part, "id", "")) for part in ast.walk(test)}
            return not _VERSIONS.isdisjoint(asked)
        case ast.Try(handlers=handlers):
            caught = (part for each in handlers if each.type for part in ast.walk(each.type))
            return any(isinstance(part, ast.Name) and part.id == "NameError" for part in caught)
    return False


def _is_print_statement(node: ast.AST) -> bool:
    """Return whether a statement is a ``print`` that is a useless expression in Python 3."""
    if not isinstance(node, ast.Expr) or isinstance(node.value, ast.Call):
        return False
    first: ast.AST = node.value
    while isinstance(first, (ast.Tuple, ast.BinOp, ast.Call)):
        first = (
            first.elts[0]
            if isinstance(first, ast.Tuple) and first.elts
            else getattr(first, "left", getattr(first, "func", ast.Pass()))
        )
    return isinstance(first, ast.Name) and first.id == "print"


def _divides_truly(tree: ast.Module) -> bool:
    return any(
        isinstance(one, ast.ImportFrom)
        and one.module == "__future__"
        and any(a.name == "division" for a in one.names)
        for one in tree.body
    )


class _Division(ast.NodeTransformer):
    """Replaces divisions of possible whole numbers by calls of a function.

    Args:
        function: its name.
        changes: receives the change.
    """

    def __init__(self, function: str, changes: list[str]) -> None:
        self._function, self._changes = function, changes

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        if not is_integer_division(node):
            return node
        self._changes.append("integer division")
        return call(self._function, node, node.left, node.right)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST:
        self.generic_visit(node)
        if not isinstance(node.op, ast.Div) or not isinstance(node.target, ast.Name) or _is_real(node.value):
            return node
        self._changes.append("integer division")
        before = ast.copy_location(ast.Name(node.target.id, ast.Load()), node)
        value = call(self._function, node, before, node.value)
        return ast.copy_location(ast.Assign([node.target], value), node)


class _Numbers(ast.NodeTransformer):
    """Makes ``float()`` and ``int()`` accept arrays of one number, as with old NumPy."""

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id in _OF_ONE and node.args and not node.keywords:
            return call(_OF_ONE[node.func.id], node, *node.args)
        return node


class _Order(ast.NodeTransformer):
    """Makes None less than anything, as in Python 2, because unset values are compared, too."""

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        self.generic_visit(node)
        sign = _SIGNS.get(type(node.ops[0]))
        if sign is None or len(node.ops) > 1:
            return node
        return call(_ORDER, node, ast.Constant(sign), node.left, node.comparators[0])


_SIGNS: dict[type[ast.cmpop], str] = {ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge"}


def is_integer_division(node: ast.BinOp) -> bool:
    """Return whether an operation is a division of possible whole numbers."""
    return isinstance(node.op, ast.Div) and not _is_real(node.left) and not _is_real(node.right)


def _is_real(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, float)


def refusal(error: SyntaxError, path: object, first_line: int) -> TransferFunctionError:
    """Return the error for code that cannot be converted."""
    line = (error.lineno or 1) + first_line - 1
    return TransferFunctionError(
        f"this is neither Python 3 nor Python 2: {error.msg}", path=str(path), line=line
    )
