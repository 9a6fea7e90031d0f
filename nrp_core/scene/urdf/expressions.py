"""Expressions in xacro files, evaluated without Python's own ``eval``.

A file of a stranger must not execute code, and must neither fill the memory nor compute for minutes. The tree
of an expression is walked here: only the operators, functions and methods listed below exist, and each value,
and the work of a whole file, is bounded.
"""

from __future__ import annotations

import ast
import operator
import re
import warnings
from collections.abc import Callable, ItemsView, Iterator, KeysView, Mapping, ValuesView
from functools import cached_property
from string import Formatter
from typing import Any, Final

from nrp_core.errors import SceneError

_LARGEST: Final = 300_000
"""The size of a value: the characters and items in it."""
_MOST_WORK: Final = 5_000_000
"""The sizes of all values of a file and the steps of their computation."""
_STEP: Final = 5
_MOST_ELEMENTS, _MOST_COPIES = 50_000, 300_000
_MAX_BITS: Final = 10_000
_MAX_WIDTH: Final = 400
_MAX_COUNT: Final = 1000
"""The largest argument of factorials, and the most arguments of a product."""
_NUMBER = re.compile(r"\d+|\*")
_CONVERSION = re.compile(r"%(?:\([^)]*\))?[#0\- +]*([\d*]*\.?[\d*]*)")

_BINARY: Final[dict[type, Callable[[Any, Any], Any]]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow,
    ast.BitAnd: operator.and_, ast.BitOr: operator.or_, ast.BitXor: operator.xor,
    ast.LShift: operator.lshift, ast.RShift: operator.rshift,
}  # fmt: skip
_UNARY: Final[dict[type, Callable[[Any], Any]]] = {
    ast.USub: operator.neg, ast.UAdd: operator.pos, ast.Not: operator.not_, ast.Invert: operator.invert,
}  # fmt: skip
_COMPARISONS: Final[dict[type, Callable[[Any, Any], Any]]] = {
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le,
    ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Is: operator.is_, ast.IsNot: operator.is_not,
    ast.In: lambda one, many: one in many, ast.NotIn: lambda one, many: one not in many,
}  # fmt: skip
_CONVERSIONS: Final[dict[int, Callable[[Any], str]]] = {ord("r"): repr, ord("s"): str, ord("a"): ascii}
_SET_METHODS: Final = ("union", "intersection", "difference", "issubset", "issuperset", "isdisjoint", "copy")
_METHODS: Final[dict[type, tuple[str, ...]]] = {
    str: (
        "lower", "upper", "title", "capitalize", "swapcase", "strip", "lstrip", "rstrip", "split", "rsplit",
        "partition", "rpartition", "splitlines", "replace", "startswith", "endswith", "find", "rfind",
        "index", "rindex", "count", "join", "format", "removeprefix", "removesuffix", "zfill", "isdigit",
        "isalpha", "isalnum", "isnumeric", "isdecimal", "islower", "isupper", "isspace", "isidentifier",
    ),
    list: ("index", "count", "copy", "append", "extend", "pop", "reverse"),
    tuple: ("index", "count"),
    dict: ("keys", "values", "items", "get", "copy", "update", "setdefault", "pop"),
    set: _SET_METHODS,
    frozenset: _SET_METHODS,
    int: ("bit_length",),
    float: ("is_integer",),
}  # fmt: skip
_NUMBERS: Final = frozenset(("real", "imag"))
_PRODUCTS: Final = frozenset(("prod", "lcm", "gcd", "factorial", "comb", "perm"))


class Budget:
    """The work that a file may still cause."""

    def __init__(self) -> None:
        self._work, self._elements, self._copies = _MOST_WORK, _MOST_ELEMENTS, _MOST_COPIES

    def spend(self, work: int) -> None:
        """Raise a SceneError if the file has caused too much work."""
        self._work -= work
        if self._work < 0:
            raise SceneError("its expressions take too many steps, or make too long texts")

    def element(self) -> None:
        """Count an element; raise a SceneError above the limit."""
        self._elements -= 1
        if self._elements < 0:
            raise SceneError(f"it expands to more than {_MOST_ELEMENTS} elements")

    def copy(self) -> None:
        """Count a copy of a part of a macro; raise a SceneError above the limit."""
        self._copies -= 1
        if self._copies < 0:
            raise SceneError(f"its macros are copied to more than {_MOST_COPIES} parts")


def size_of(value: object) -> int:
    """Return the characters and items in a value and in its items; if it is too large, more than a bound."""
    total, waiting = 0, [value]
    while waiting and total <= _LARGEST:
        one = waiting.pop()
        if isinstance(one, str):
            total += len(one)
        elif isinstance(one, int):
            total += one.bit_length() // 8
        elif isinstance(one, list | tuple | set | frozenset):
            waiting += [*one][: _LARGEST + 1]
        elif isinstance(one, dict):
            waiting += [*one.keys(), *one.values()]
        elif isinstance(one, range):
            total += len(one)
        total += 1
    return total


def _refuse_size() -> SceneError:
    return SceneError(f"a value has more than {_LARGEST} characters or items")


class Evaluator:
    """Evaluates the expressions of one file.

    Args:
        functions: the functions that expressions may call, each with its name.
        budget: of the file.
        instead: functions that replace those with the same names.
    """

    def __init__(
        self, functions: list[tuple[str, Any]], budget: Budget, instead: Mapping[str, Callable[..., Any]]
    ) -> None:
        self._names = {id(function): name for name, function in functions}
        self._functions = functions  # kept, so that no other object gets the identity of one
        self._budget, self._instead = budget, instead

    def evaluate(self, expression: str, names: Any) -> Any:
        """Return the value of an expression.

        Args:
            expression: in Python.
            names: a mapping of names to values; it may compute them.

        Raises:
            SceneError: it uses a forbidden operation.
            SyntaxError, NameError, ValueError, ...: it is wrong.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(expression.strip(), "<expression>", mode="eval")
        return self.bounded(_Walk(self, names).value(tree.body))

    def step(self) -> None:
        """Count a step."""
        self._budget.spend(_STEP)

    def bounded(self, value: Any) -> Any:
        """Return a value that is not too large, and count its size."""
        if isinstance(value, Iterator):
            value = _drawn(value)
        elif isinstance(value, KeysView | ValuesView | ItemsView):
            value = list(value)
        if isinstance(value, int) and value.bit_length() > _MAX_BITS:
            raise SceneError(f"a number has more than {_MAX_BITS} bits")
        size = size_of(value)
        if size > _LARGEST:
            raise _refuse_size()
        self._budget.spend(size)
        return value

    def call(self, function: Any, arguments: list[Any], keywords: dict[str, Any]) -> Any:
        """Return the result of a function."""
        name = self._names.get(id(function))
        if name in (None, "vars") or (name == "type" and len(arguments) != 1):
            raise SceneError(f"an expression may not call '{name or type(function).__name__}'")
        given = [self.bounded(one) for one in (*arguments, *keywords.values())]
        _check_arguments(name, given)
        if (key := keywords.get("key")) is not None:
            keywords["key"] = lambda item: self.call(key, [item], {})
        if name in ("map", "filter"):
            return self.bounded(self._mapped(name, *arguments))
        return self.bounded(self._instead.get(name, function)(*arguments, **keywords))

    def _mapped(self, name: str, function: Any, *items: Any) -> list[Any]:
        if name == "filter":
            return [one for one in items[0] if (one if function is None else self.call(function, [one], {}))]
        return [self.call(function, list(given), {}) for given in zip(*items, strict=False)]

    def call_method(self, owner: Any, method: str, arguments: list[Any], keywords: dict[str, Any]) -> Any:
        """Return the result of a method."""
        for one in (owner, *arguments, *keywords.values()):
            self.bounded(one)
        if isinstance(owner, str):
            _check_text_method(owner, method, arguments)
        value = getattr(owner, method)(*arguments, **keywords)
        self.bounded(owner)  # it may have grown
        return self.bounded(value)


def _drawn(values: Any) -> list[Any]:
    """Return the items of an iterator, but no more than a value may have."""
    return [item for item, _ in zip(values, range(_LARGEST + 1), strict=False)]


def _check_arguments(name: str, given: list[Any]) -> None:
    """Raise a SceneError for arguments with which a function would take minutes or gigabytes."""
    items = [
        item for value in given for item in (value if isinstance(value, list | tuple | range) else [value])
    ]
    if name in _PRODUCTS:
        is_large = any(isinstance(item, int) and abs(item) > _MAX_COUNT for item in items)
        if len(items) > _MAX_COUNT or (name in ("factorial", "comb", "perm") and is_large):
            raise SceneError(f"{name}() with more than {_MAX_COUNT}")
    if name == "round" and len(given) == 2 and isinstance(given[1], int) and abs(given[1]) > _MAX_WIDTH:
        raise SceneError(f"round() to more than {_MAX_WIDTH} digits")
    if name == "tokenize" and "]" in "".join(one for one in given[1:] if isinstance(one, str)):
        raise SceneError("separators of tokenize() with ']'")
    if name == "sum" and len(given) > 1 and not isinstance(given[1], int | float | complex):
        raise SceneError("sum() of lists")


def _check_text_method(text: str, method: str, arguments: list[Any]) -> None:
    """Raise a SceneError for a text method that returns too long a result or reads attributes."""
    given = sum(map(size_of, arguments))
    length = 0
    if method == "replace" and len(arguments) > 1:
        length = (text.count(str(arguments[0])) + 1) * size_of(arguments[1])
    elif method == "join" and arguments and hasattr(arguments[0], "__len__"):
        length = len(arguments[0]) * len(text) + given
    elif method == "zfill" and arguments:
        length = arguments[0] if isinstance(arguments[0], int) else 0
    elif method == "format":
        length = (text.count("{") + 1) * (given + 1) + len(text)
        for _, field, how, _ in Formatter().parse(text):
            _check_widths(how or "")
            if not {".", "[", "{"}.isdisjoint((field or "") + (how or "").replace(".", "")):
                raise SceneError("format() of attributes, items and formats")
    if length > _LARGEST:
        raise _refuse_size()


def _check_widths(how: str) -> None:
    """Raise a SceneError for a format that makes a text much longer than its value."""
    if any(width == "*" or len(width) > 3 or int(width) > _MAX_WIDTH for width in _NUMBER.findall(how)):
        raise SceneError(f"a format with a width above {_MAX_WIDTH}")


class _Walk:
    """The walk over one expression."""

    def __init__(self, evaluator: Evaluator, names: Any) -> None:
        self._evaluator, self._names = evaluator, names
        self._local: list[dict[str, Any]] = []

    def value(self, node: ast.AST) -> Any:
        """Return the value of a part of the expression."""
        self._evaluator.step()
        work = self._kinds.get(type(node))
        if work is None:
            raise SceneError(f"'{ast.unparse(node)}' is not possible in an expression")
        return work(node)

    @cached_property
    def _kinds(self) -> dict[type, Callable[[Any], Any]]:
        return {
            ast.Constant: self._constant, ast.Name: self._name, ast.Attribute: self._attribute,
            ast.Subscript: self._subscript, ast.Slice: self._slice, ast.BinOp: self._binary,
            ast.UnaryOp: self._unary, ast.BoolOp: self._logic, ast.Compare: self._compare,
            ast.IfExp: lambda node: self.value(node.body if self.value(node.test) else node.orelse),
            ast.Call: self._call, ast.JoinedStr: self._text, ast.FormattedValue: self._formatted,
            ast.List: lambda node: self._kept(self._items(node.elts)),
            ast.Tuple: lambda node: self._kept(tuple(self._items(node.elts))),
            ast.Set: lambda node: self._kept(set(self._items(node.elts))),
            ast.Dict: self._mapping, ast.ListComp: lambda node: self._comprehended(node, list),
            ast.GeneratorExp: lambda node: self._comprehended(node, list),
            ast.SetComp: lambda node: self._comprehended(node, set), ast.DictComp: self._comprehended_mapping,
        }  # fmt: skip

    def _kept(self, value: Any) -> Any:
        return self._evaluator.bounded(value)

    def _constant(self, node: ast.Constant) -> Any:
        if isinstance(node.value, bytes):
            raise SceneError("bytes are not possible in an expression")
        return self._kept(node.value)

    def _name(self, node: ast.Name) -> Any:
        for names in reversed(self._local):
            if node.id in names:
                return names[node.id]
        if node.id.startswith("__"):
            raise SceneError(f"the name '{node.id}' is not possible in an expression")
        try:
            return self._names[node.id]
        except KeyError:
            raise NameError(f"name '{node.id}' is not defined") from None

    def _attribute(self, node: ast.Attribute) -> Any:
        owner = self.value(node.value)
        if node.attr.startswith("_"):
            raise SceneError(f"the attribute '{node.attr}' is not possible in an expression")
        if isinstance(owner, dict):  # a namespace, or values of a file
            try:
                return owner[node.attr]
            except (KeyError, AttributeError):
                raise AttributeError(f"there is no '{node.attr}' in '{ast.unparse(node.value)}'") from None
        if isinstance(owner, int | float | complex) and node.attr in _NUMBERS:
            return getattr(owner, node.attr)
        raise SceneError(f"the attribute '{node.attr}' is not possible in an expression")

    def _call(self, node: ast.Call) -> Any:
        arguments = self._items(node.args)
        keywords: dict[str, Any] = {}
        for keyword in node.keywords:
            given = self.value(keyword.value)
            keywords |= given if keyword.arg is None else {keyword.arg: given}
        if isinstance(node.func, ast.Attribute):
            owner = self.value(node.func.value)
            if self._is_method(owner, node.func.attr):
                return self._evaluator.call_method(owner, node.func.attr, arguments, keywords)
        return self._evaluator.call(self.value(node.func), arguments, keywords)

    @staticmethod
    def _is_method(owner: Any, name: str) -> bool:
        """Return whether an object has a method that may be called; namespaces have none."""
        kind = next((kind for kind in type(owner).__mro__ if kind in _METHODS), None)
        is_namespace = hasattr(owner, "parent") if isinstance(owner, dict) else False
        return kind is not None and name in _METHODS[kind] and not is_namespace

    def _items(self, nodes: list[ast.expr]) -> list[Any]:
        found: list[Any] = []
        for node in nodes:
            if isinstance(node, ast.Starred):
                found += _drawn(self.value(node.value))
            else:
                found.append(self.value(node))
        return found

    def _mapping(self, node: ast.Dict) -> Any:
        made: dict[Any, Any] = {}
        for key, value in zip(node.keys, node.values, strict=True):
            made |= self.value(value) if key is None else {self.value(key): self.value(value)}
        return self._kept(made)

    def _subscript(self, node: ast.Subscript) -> Any:
        return self._kept(self.value(node.value)[self.value(node.slice)])

    def _slice(self, node: ast.Slice) -> slice:
        return slice(*(one and self.value(one) for one in (node.lower, node.upper, node.step)))

    def _binary(self, node: ast.BinOp) -> Any:
        left, right = self._kept(self.value(node.left)), self._kept(self.value(node.right))
        kind = type(node.op)
        work = _BINARY.get(kind)
        if work is None:
            raise SceneError(f"'{ast.unparse(node)}' is not possible in an expression")
        _check_operands(node, left, right)
        return self._kept(work(left, right))

    def _unary(self, node: ast.UnaryOp) -> Any:
        return self._kept(_UNARY[type(node.op)](self.value(node.operand)))

    def _logic(self, node: ast.BoolOp) -> Any:
        found: Any = None
        for operand in node.values:
            found = self.value(operand)
            if bool(found) is isinstance(node.op, ast.Or):
                break
        return found

    def _compare(self, node: ast.Compare) -> Any:
        left, found = self.value(node.left), True
        for kind, right in zip(node.ops, map(self.value, node.comparators), strict=True):
            self._kept(right)
            found = _COMPARISONS[type(kind)](left, right)
            if not found:
                break
            left = right
        return found

    def _text(self, node: ast.JoinedStr) -> Any:
        return self._kept("".join(str(self.value(part)) for part in node.values))

    def _formatted(self, node: ast.FormattedValue) -> Any:
        value = self._kept(self.value(node.value))
        how = self.value(node.format_spec) if node.format_spec else ""
        _check_widths(how)
        if (convert := _CONVERSIONS.get(node.conversion)) is not None:
            value = convert(value)
        return self._kept(format(value, how))

    def _comprehended(self, node: ast.ListComp | ast.SetComp | ast.GeneratorExp, kind: Any) -> Any:
        return self._kept(kind(_bounded_items(self.value(node.elt) for _ in self._rounds(node.generators))))

    def _comprehended_mapping(self, node: ast.DictComp) -> Any:
        rounds = self._rounds(node.generators)
        return self._kept(
            dict(_bounded_items((self.value(node.key), self.value(node.value)) for _ in rounds))
        )

    def _rounds(self, generators: list[ast.comprehension]) -> Iterator[None]:
        """Go through the rounds of a comprehension, with their names."""
        if not generators:
            yield
            return
        first, *rest = generators
        items = self.value(first.iter)
        self._local.append({})
        for item in items:
            self._evaluator.step()
            self._bind(first.target, item)
            if all(self.value(test) for test in first.ifs):
                yield from self._rounds(rest)
        self._local.pop()

    def _bind(self, target: ast.AST, item: Any) -> None:
        if isinstance(target, ast.Tuple | ast.List):
            items = _drawn(item)
            if len(items) != len(target.elts):
                raise ValueError(f"{len(items)} values for {len(target.elts)} names")
            for one, value in zip(target.elts, items, strict=True):
                self._bind(one, value)
        elif isinstance(target, ast.Name):
            self._local[-1][target.id] = item
        else:
            raise SceneError(f"'{ast.unparse(target)}' is not possible in an expression")


def _bounded_items(items: Iterator[Any]) -> Iterator[Any]:
    size = 0
    for item in items:
        size += size_of(item)
        if size > _LARGEST:
            raise _refuse_size()
        yield item


def _check_operands(node: ast.BinOp, left: Any, right: Any) -> None:
    """Raise a SceneError for operands whose result would be too large."""
    kind = type(node.op)
    if kind is ast.Mod and isinstance(left, str):
        _check_widths(" ".join(_CONVERSION.findall(left)))
        if left.count("%") * size_of(right) > 10 * _LARGEST:
            raise _refuse_size()
    if kind is ast.Mult:
        sizes = [one if isinstance(one, int) else size_of(one) for one in (left, right)]
        if not (isinstance(left, int | float | complex) and isinstance(right, int | float | complex)):
            if sizes[0] * sizes[1] > _LARGEST:
                raise _refuse_size()
            return
    if not (isinstance(left, int) and isinstance(right, int)):
        return
    power, base = ast.unparse(node), left.bit_length()
    if kind is ast.Pow and base * right > _MAX_BITS:
        raise SceneError(f"the power '{power}' has more than {_MAX_BITS} bits")
    if kind is ast.LShift and base + right > _MAX_BITS:
        raise SceneError(f"the number '{power}' has more than {_MAX_BITS} bits")
