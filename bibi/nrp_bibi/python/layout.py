"""Break lines of Python that are too long, as ``ruff format`` does."""

from __future__ import annotations

import ast

from nrp_bibi.python.document import INDENT, Document, bracketed, rendered, separated
from nrp_bibi.python.printer import document, flat, precedence, unbroken

WIDTH = 88


def laid_out(line: str, width: int = WIDTH) -> str:
    """Return a line, broken into several if it is too long.

    Args:
        line: a comment, decorator, head of a function, assignment, call or return, indented, on one line.
        width: the maximum length of a line.
    """
    text = line.lstrip(" ")
    indent = len(line) - len(text)
    if len(line) <= width or not text or text.startswith("#"):
        return line
    if text.startswith("@"):
        head, body = "@", _expression(text[1:])
    elif text.startswith("def "):
        return line[:indent] + _definition(text, indent, width)
    else:
        head, body = _statement(text)
    start = " " * indent + head
    inner = _right_hand_side(body, len(start), indent, width)
    return start + rendered(inner, width, len(start), indent)


def _expression(text: str) -> ast.expr:
    return ast.parse(text, mode="eval").body


def _definition(text: str, indent: int, width: int) -> str:
    function = ast.parse(text + " ...").body[0]
    assert isinstance(function, ast.FunctionDef)
    parameters = separated([argument.arg for argument in function.args.args])
    return rendered([f"def {function.name}", bracketed("(", parameters, ")"), ":"], width, indent, indent)


def _statement(text: str) -> tuple[str, ast.expr]:
    """Return the text before the expression of a statement, and the expression."""
    # The return is outside a function here; only the compiler would refuse that.
    match ast.parse(text).body[0]:
        case ast.Assign(value=value) | ast.Return(value=ast.expr() as value) | ast.Expr(value=value):
            return text[: value.col_offset - _parentheses_before(text, value)], value
        case other:
            raise TypeError(f"no layout for {ast.dump(other)}")


def _parentheses_before(text: str, value: ast.expr) -> int:
    """Return the number of leading bracket characters that are not in the syntax tree."""
    before = text.encode()[: value.col_offset].decode()
    return len(before) - len(before.rstrip("("))


def _right_hand_side(value: ast.expr, column: int, indent: int, width: int) -> Document:
    """Return an expression that stands alone, in parentheses if it cannot be broken otherwise."""
    inner = document(value)
    if isinstance(value, ast.Call):
        return inner
    if isinstance(value, ast.BinOp) and _has_brackets_to_break(value):
        before_brackets = rendered(unbroken(value), 0).partition("\n")[0]
        if column + len(before_brackets) <= width:
            return unbroken(value)
    wrapped = bracketed("(", inner, ")")
    stays_too_long = not isinstance(value, ast.BinOp) and indent + INDENT + len(flat(value)) > width
    return inner if stays_too_long else wrapped


def _has_brackets_to_break(value: ast.BinOp) -> bool:
    """Return whether an operation with one operator of lowest precedence begins or ends with brackets."""
    first, last = value.left, value.right
    if isinstance(first, ast.BinOp) and precedence(first) == precedence(value):
        return False
    around = precedence(value)
    while isinstance(last, ast.BinOp) and precedence(last) > around:
        last, around = last.right, precedence(last)
    around = precedence(value)
    while isinstance(first, ast.BinOp) and precedence(first) >= around:
        first, around = first.left, precedence(first)
    has_arguments = isinstance(last, ast.Call) and bool(last.args or last.keywords)
    return has_arguments or isinstance(last, ast.BinOp) or isinstance(first, ast.BinOp)
