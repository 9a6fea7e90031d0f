"""Expressions as documents, with parentheses only where precedence needs them."""

from __future__ import annotations

import ast
from math import inf
from typing import Final

from nrp_bibi.python.document import Document, Group, Line, bracketed, collected, rendered, separated

_SUM, _PRODUCT, _SIGN, _ATOM = range(4)
_OPERATORS: Final[dict[type[ast.operator], tuple[str, int]]] = {
    ast.Add: ("+", _SUM),
    ast.Sub: ("-", _SUM),
    ast.Mult: ("*", _PRODUCT),
    ast.Div: ("/", _PRODUCT),
}


def flat(expression: ast.expr) -> str:
    """Return an expression on one line."""
    return rendered(document(expression), inf)


def document(node: ast.expr) -> Document:
    """Return the document of an expression of a generated transfer function."""
    match node:
        case ast.Name(id=name):
            return name
        case ast.Constant(value=str() as text):
            return quoted(text)
        case ast.Constant(value=value):
            return repr(value).replace("e+", "e")
        case ast.Attribute(value=owner, attr=name):
            return [_within(owner, _ATOM), f".{name}"]
        case ast.Call(func=function, args=arguments, keywords=keywords):
            given = [*map(document, arguments), *map(_keyword, keywords)]
            return [_within(function, _ATOM), bracketed("(", separated(given), ")") if given else "()"]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return ["-", _within(operand, _SIGN)]
        case ast.BinOp():
            return Group(_operation(node, Line(" ")))
        case _:
            return _container(node)


def _container(node: ast.expr) -> Document:
    match node:
        case ast.Subscript(value=owner, slice=ast.Tuple(elts=parts)):
            return [_within(owner, _ATOM), bracketed("[", separated([*map(document, parts)]), "]")]
        case ast.Subscript(value=owner, slice=index):
            return [_within(owner, _ATOM), bracketed("[", document(index), "]")]
        case ast.Slice():
            return _slice(node)
        case ast.List(elts=parts):
            return collected("[", [*map(document, parts)], "]")
        case ast.Dict(keys=keys, values=values):
            pairs = [
                [document(key), ": ", document(value)] for key, value in zip(keys, values, strict=True) if key
            ]
            return collected("{", pairs, "}")
        case ast.Lambda(args=ast.arguments(args=[ast.arg(arg=parameter)]), body=body):
            return [f"lambda {parameter}: ", document(body)]
        case _:
            raise TypeError(f"no text for {ast.dump(node)}")


def _keyword(keyword: ast.keyword) -> Document:
    return [f"{keyword.arg}=", document(keyword.value)]


def _slice(node: ast.Slice) -> Document:
    """Return ``a:b``, with spaces around the colon if a bound is not a plain name or number."""
    bounds = [bound for bound in (node.lower, node.upper, node.step) if bound is not None]
    plain = all(isinstance(bound, (ast.Name, ast.Constant)) for bound in bounds)
    return (":" if plain else " : ").join(map(flat, bounds))


def unbroken(node: ast.BinOp) -> Document:
    """Return an operation outside brackets, where a line cannot be broken before an operator."""
    return _operation(node, " ")


def _operation(node: ast.BinOp, space: Document) -> list[Document]:
    """Return a chain of operators of one precedence, with a space or line before each operator."""
    sign, level = _OPERATORS[type(node.op)]
    left = node.left
    if isinstance(left, ast.BinOp) and precedence(left) == level:
        chain = _operation(left, space)
    else:
        chain = [_within(left, level, space)]
    return [*chain, space, f"{sign} ", _within(node.right, level + 1, space)]


def _within(node: ast.expr, level: int, space: Document | None = None) -> Document:
    """Return an operand, in parentheses if its place needs a higher precedence."""
    if precedence(node) < level:
        return bracketed("(", document(node), ")")
    if isinstance(node, ast.BinOp) and space == " ":
        return unbroken(node)
    return document(node)


def precedence(node: ast.expr) -> int:
    """Return the precedence of an expression; higher binds tighter."""
    match node:
        case ast.BinOp(op=operator):
            return _OPERATORS[type(operator)][1]
        case ast.UnaryOp():
            return _SIGN
        case ast.Lambda():
            return _SUM - 1
        case ast.Constant(value=int() | float()):
            return _SIGN  # 2.real is not valid Python
        case _:
            return _ATOM


def quoted(text: str) -> str:
    """Return a literal in double quotes, unless single ones need fewer escapes."""
    quote = "'" if text.count('"') > text.count("'") else '"'
    return quote + "".join(_escaped(character, quote) for character in text) + quote


def _escaped(character: str, quote: str) -> str:
    if character in "'\"":
        return f"\\{character}" if character == quote else character
    return repr(character)[1:-1]
