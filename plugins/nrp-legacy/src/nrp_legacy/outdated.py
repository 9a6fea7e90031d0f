"""Replace methods and results that Python 3 and today's libraries no longer have."""

from __future__ import annotations

import ast

ROUND = "_round_of_python_2"
INDEX = "_index_of_numpy_1"
HELPERS = {
    "_next_of_python_2": "next_of", "_sort_of_python_2": "sort", "_text_of_python_2": "text_of",
    "_message_of_python_2": "message_of", "_bytes_of_numpy_1": "bytes_of", "_ptp_of_numpy_1": "ptp_of",
    "_itemset_of_numpy_1": "itemset_of", "_rgb_of_matplotlib_1": "rgb_of",
    ROUND: "round_of", INDEX: "index_of",
}  # fmt: skip
"""The names under which converted code finds functions of :mod:`nrp_legacy.builtins2`."""
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
        """Return the function that replaces a method call, if there is one."""
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
