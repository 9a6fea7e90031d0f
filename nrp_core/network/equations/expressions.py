"""Expressions in equations: their permitted syntax, and the place of a mistake."""

from __future__ import annotations

import ast
import warnings
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from math import e, inf, pi
from typing import Final, NoReturn

from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.units import NONE, Dimension, as_unit, times, units

FUNCTIONS: Final = {
    "exp": 1, "expm1": 1, "exprel": 1, "log": 1, "log10": 1, "log1p": 1, "sin": 1, "cos": 1, "tan": 1,
    "arcsin": 1, "arccos": 1, "arctan": 1, "sinh": 1, "cosh": 1, "tanh": 1, "sqrt": 1, "abs": 1, "sign": 1,
    "floor": 1, "ceil": 1, "int": 1, "clip": 3, "min": 2, "max": 2,
}  # fmt: skip
"""The functions in equations, and their number of arguments."""
CONSTANTS: Final = {"pi": pi, "e": e, "inf": inf, "True": True, "False": False}
TIME: Final = "t"
WEIGHT: Final = "weight"
"""The weight of an arriving spike in the effect of a receptor, and that of a synapse in its statements."""
RANDOM: Final = "rand"
"""A number from 0 to below 1 that is new in each step, in the threshold of a cell."""
STEP: Final = "dt"
"""The step, beside a random number."""
RESERVED: Final = frozenset({*FUNCTIONS, *CONSTANTS, TIME, WEIGHT, "dt", "xi"})
_UNIT: Final = 0.75
"""How similar an unknown name must be to a unit for the unit to be proposed."""
_NOISE: Final = frozenset({"xi", "rand", "randn", "poisson"})

_ALLOWED: Final = (
    ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.Call, ast.Name, ast.Constant,
    ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow, ast.USub, ast.UAdd, ast.Not, ast.And,
    ast.Or, ast.Gt, ast.GtE, ast.Lt, ast.LtE, ast.Eq, ast.NotEq, ast.Load,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class TextOrigin:
    """Where a text was written.

    Args:
        where: the argument that contains it, e.g. ``equations``.
        text: the text.
        line: its first line, from 1; 0 if it has only one.
        kind: the kind of object that equations define, by its name in scripts.
    """

    where: str
    text: str
    line: int = 0
    kind: str = "EquationCell"

    def refuse(self, problem: str) -> NoReturn:
        """Raise the error for a mistake here.

        Raises:
            NetworkError: always.
        """
        line = f", line {self.line}" if self.line else ""
        raise NetworkError(f"{self.kind}: {self.where}{line}, '{' '.join(self.text.split())}': {problem}")


def require_ascii(place: TextOrigin) -> None:
    """Refuse letters of other alphabets, which look alike."""
    if not place.text.isascii():
        letter = next(one for one in place.text if not one.isascii())
        place.refuse(f"{letter!r} is not an ASCII character; names are written as in tau or alpha_1")


def parsed(text: str, place: TextOrigin, *, random: bool = False) -> ast.expr:
    """Return an expression.

    Args:
        text: the text.
        place: its place in the source.
        random: whether it may contain ``rand()``, once; it becomes a name.

    Raises:
        NetworkError: it is not an expression of equations.
    """
    require_ascii(place)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)
            found = ast.parse(f"({text.strip()})", mode="eval").body
    except (SyntaxError, RecursionError, MemoryError):
        hint = "; equality is written ==" if "=" in text and "==" not in text else ""
        place.refuse(f"'{' '.join(text.split())}' is not an expression{hint}")
    if random:
        drawn = _Drawn()
        found = drawn.visit(found)
        if drawn.n > 1:
            place.refuse("'rand()' stands more than once; compare one random number")
    for node in ast.walk(found):
        _require_allowed(node, place)
    return found


class _Drawn(ast.NodeTransformer):
    """Replaces calls that draw a number by a name, and counts them."""

    n = 0

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if isinstance(node.func, ast.Name) and node.func.id == RANDOM and not node.args:
            self.n += 1
            return ast.Name(RANDOM)
        self.generic_visit(node)
        return node


def names_in(node: ast.expr) -> Iterator[str]:
    """Yield the names in an expression that are not those of functions."""
    parts = list(ast.walk(node))
    functions = {id(call.func) for call in parts if isinstance(call, ast.Call)}
    for part in parts:
        if isinstance(part, ast.Name) and id(part) not in functions:
            yield part.id


def require_known(node: ast.expr, known: Mapping[str, object], place: TextOrigin) -> None:
    """Refuse an expression with an unknown name.

    Args:
        node: the expression.
        known: the names that it may use.
        place: its place in the source.

    Raises:
        NetworkError: a name is unknown.
    """
    for name in names_in(node):
        if name in known:
            continue
        if name in _NOISE:
            place.refuse(f"'{name}' is random; noise comes from sources and devices, not from equations")
        if name == WEIGHT:
            place.refuse("'weight' is only known where a spike acts")
        if name == "dt":
            place.refuse("'dt' is not known in equations, which do not depend on the step")
        if name in FUNCTIONS:
            place.refuse(f"'{name}' is a function; write {name}(...)")
        own, other = ([one for one in known if (one in units()) is is_unit] for is_unit in (False, True))
        near = [*own, *get_close_matches(name, other, cutoff=_UNIT)]  # some unit is like any short name
        hint = did_you_mean(name, near)
        place.refuse(
            f"unknown name '{name}'{hint}; a parameter is declared in `parameters`, e.g. '{name}': '20 ms'"
        )


class _Resolved(ast.NodeTransformer):
    """Replaces the names of constants and units by their values in SI units."""

    def __init__(self, own: Container[str]) -> None:
        self._own = own

    def visit_Call(self, node: ast.Call) -> ast.Call:
        return ast.Call(node.func, [self.visit(argument) for argument in node.args], [])

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in self._own or node.id == TIME:
            return node
        return ast.Constant(CONSTANTS[node.id] if node.id in CONSTANTS else units()[node.id].scale)


def resolved(node: ast.expr, own: Container[str]) -> ast.expr:
    """Return an expression with numbers instead of constants and units.

    Args:
        node: the expression.
        own: the names of variables, definitions and parameters, which come before those of units.
    """
    found: ast.expr = _Resolved(own).visit(node)
    return found


def _require_allowed(node: ast.AST, place: TextOrigin) -> None:
    if isinstance(node, ast.BitXor):
        place.refuse("a power is written with **")
    if isinstance(node, ast.Attribute):
        place.refuse(f"functions are written without a module: {node.attr}(...)")
    if isinstance(node, ast.Call):
        _require_function(node, place)
    if isinstance(node, ast.Constant) and not isinstance(node.value, (int, float)):
        place.refuse(f"{node.value!r} is not a number")
    if isinstance(node, (ast.BitAnd, ast.BitOr, ast.Invert)):
        place.refuse("conditions are combined with `and`, `or` and `not`")
    if not isinstance(node, _ALLOWED):
        place.refuse(f"'{type(node).__name__}' has no meaning in an equation")


def _require_function(call: ast.Call, place: TextOrigin) -> None:
    if not isinstance(call.func, ast.Name):
        place.refuse(f"'{ast.unparse(call.func)}' is not a function; there are {', '.join(FUNCTIONS)}")
    name = call.func.id
    if name in _NOISE:
        place.refuse(f"'{name}' is random; noise comes from sources and devices, not from equations")
    if name not in FUNCTIONS:
        place.refuse(f"there is no function '{name}'{did_you_mean(name, FUNCTIONS)}")
    if call.keywords or len(call.args) != FUNCTIONS[name]:
        place.refuse(f"{name} takes {FUNCTIONS[name]} argument{'s' * (FUNCTIONS[name] > 1)}")


TRUTH: Final[Dimension] = (Fraction(1),)
"""That of a condition."""
ANY: Final[Dimension] = (Fraction(0),)
"""That of a bare 0, which is 0 in any unit."""
_SAME: Final = frozenset({"abs", "floor", "ceil", "clip", "min", "max"})
"""Functions whose value has the unit of their arguments."""


def dimension_of(node: ast.expr, names: Mapping[str, Dimension], place: TextOrigin) -> Dimension:
    """Return the dimension of an expression.

    Args:
        node: the expression.
        names: the dimensions of the names in it.
        place: its place in the source.

    Raises:
        NetworkError: units do not fit together.
    """
    match node:
        case ast.Name(id=name):
            return names[name]
        case ast.Constant(value=value):
            return TRUTH if isinstance(value, bool) else ANY if value == 0 else NONE
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            _require_truth(operand, names, place)
            return TRUTH
        case ast.UnaryOp(operand=operand):
            return _number(operand, names, place)
        case ast.BoolOp(values=parts):
            for part in parts:
                _require_truth(part, names, place)
            return TRUTH
        case ast.Compare(left=left, comparators=others):
            _alike([left, *others], names, place, "compares")
            return TRUTH
        case ast.BinOp():
            return _dimension_of_operation(node, names, place)
        case ast.Call(func=ast.Name(id=function), args=arguments):
            return _dimension_of_call(function, arguments, names, place)
    raise AssertionError(ast.dump(node))


def require_dimension(
    node: ast.expr, names: Mapping[str, Dimension], place: TextOrigin, expected: Dimension, what: str
) -> None:
    """Refuse an expression that does not have a dimension.

    Args:
        node: the expression.
        names: the dimensions of the names in it.
        place: its place in the source.
        expected: the dimension; ``TRUTH`` for a condition.
        what: the quantity with that dimension, for the message.

    Raises:
        NetworkError: it has another one.
    """
    found = dimension_of(node, names, place)
    if found not in (expected, ANY) or (found == ANY and expected == TRUTH):
        place.refuse(f"'{ast.unparse(node)}' {_is(found)}, but {what} {_is(expected)}")


def _is(of: Dimension) -> str:
    if of == TRUTH:
        return "is a condition"
    return "is a number without a unit" if of in (NONE, ANY) else f"is in {as_unit(of)}"


def _number(node: ast.expr, names: Mapping[str, Dimension], place: TextOrigin) -> Dimension:
    found = dimension_of(node, names, place)
    if found == TRUTH:
        place.refuse(f"'{ast.unparse(node)}' is a condition; as a number, 1 or 0, it is int(...)")
    return found


def _require_truth(node: ast.expr, names: Mapping[str, Dimension], place: TextOrigin) -> None:
    require_dimension(node, names, place, TRUTH, "a part of a condition")


def _alike(nodes: list[ast.expr], names: Mapping[str, Dimension], place: TextOrigin, verb: str) -> Dimension:
    """Return the dimension that expressions share."""
    found = [(node, _number(node, names, place)) for node in nodes]
    known = [(node, of) for node, of in found if of != ANY]
    for node, of in known[1:]:
        if of != known[0][1]:
            first = known[0][0]
            place.refuse(
                f"{verb} '{ast.unparse(first)}', which {_is(known[0][1])}, and '{ast.unparse(node)}', which "
                f"{_is(of)}"
            )
    return known[0][1] if known else ANY


def _dimension_of_operation(node: ast.BinOp, names: Mapping[str, Dimension], place: TextOrigin) -> Dimension:
    if isinstance(node.op, (ast.Add, ast.Sub, ast.Mod)):
        verb = {ast.Add: "adds", ast.Sub: "subtracts", ast.Mod: "divides"}[type(node.op)]
        return _alike([node.left, node.right], names, place, verb)
    if isinstance(node.op, ast.FloorDiv):  # a whole number of what has a unit would depend on the unit
        _alike([node.left, node.right], names, place, "counts by //")
        return NONE
    base = _number(node.left, names, place)
    if isinstance(node.op, ast.Pow):
        return _power(base, node, names, place)
    second = _number(node.right, names, place)
    if ANY in (base, second):
        return ANY if base == ANY else NONE if isinstance(node.op, ast.Div) else ANY
    return times(base, second, 1 if isinstance(node.op, ast.Mult) else -1)


def _power(base: Dimension, node: ast.BinOp, names: Mapping[str, Dimension], place: TextOrigin) -> Dimension:
    require_dimension(node.right, names, place, NONE, "an exponent")
    if base in (NONE, ANY):
        return base
    try:
        exponent = ast.literal_eval(node.right)
    except ValueError:
        place.refuse(f"'{ast.unparse(node)}': the exponent of a number with a unit is itself a plain number")
    power = Fraction(exponent).limit_denominator(12)
    return tuple(power * one for one in base)


def _dimension_of_call(
    name: str, arguments: list[ast.expr], names: Mapping[str, Dimension], place: TextOrigin
) -> Dimension:
    if name == "int":
        dimension_of(arguments[0], names, place)
        return NONE
    if name in _SAME:
        return _alike(arguments, names, place, f"{name} compares")
    found = _number(arguments[0], names, place)
    if name == "sqrt" and found != ANY:
        return tuple(one / 2 for one in found)
    if name != "sign" and found not in (NONE, ANY):
        place.refuse(
            f"{name} takes a number without a unit, and '{ast.unparse(arguments[0])}' {_is(found)}; divide "
            "it by a scale"
        )
    return NONE
