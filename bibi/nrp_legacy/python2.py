"""Turn leftovers of Python 2 into Python 3, so that code of its time runs.

Only code that Python 3 refuses is rewritten; the methods that Python 3 has dropped are renamed in any.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from nrp_core.errors import TransferFunctionError

DIVIDE = "_divide_of_python_2"
"""The name under which converted code finds :func:`divide`."""

_METHODS = {"iteritems": "items", "itervalues": "values", "iterkeys": "keys"}
_NAMES = {"xrange": range, "unicode": str, "basestring": str, "long": int, "raw_input": input, "unichr": chr}


def divide(left: object, right: object) -> object:
    """Divide as Python 2: of two integers, the quotient rounded down."""
    if isinstance(left, int) and isinstance(right, int):
        return left // right
    return left / right  # type: ignore[operator]


def names() -> dict[str, object]:
    """Return what Python 2 had built in and Python 3 has not."""
    from functools import reduce

    return {**_NAMES, "reduce": reduce, DIVIDE: divide}


@dataclass(frozen=True, slots=True)
class Converted:
    """Code that Python 3 takes.

    Args:
        tree: what it means; line numbers are those of the original.
        changes: what was changed, in a few words.
    """

    tree: ast.Module
    changes: tuple[str, ...]


def converted(code: str) -> Converted:
    """Return what code means that may be of Python 2.

    Raises:
        SyntaxError: it is neither Python 3 nor anything that is converted.
    """
    changes: list[str] = []
    tree, refused = _parsed(code)
    if tree is None or any(map(_is_print_statement, ast.walk(tree))):
        text, changes = _rewritten(code)
        tree, _ = _parsed(text)
        if tree is None:
            raise refused or SyntaxError("not converted")
        if not _divides_truly(tree):
            tree = _Division(changes).visit(tree)
    tree = _Methods(changes).visit(tree)
    return Converted(ast.fix_missing_locations(tree), tuple(dict.fromkeys(changes)))


def rewritten(code: str) -> str:
    """Return code as text that Python 3 takes; divisions and methods stay as they are."""
    text, _ = _rewritten(code)
    return text


def _parsed(code: str) -> tuple[ast.Module | None, SyntaxError | None]:
    try:
        return ast.parse(code), None
    except SyntaxError as error:
        return None, error


def _is_print_statement(node: ast.AST) -> bool:
    """Whether a statement is one of ``print`` that Python 3 takes for something without use."""
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


# -- by lines and tokens


def _rewritten(code: str) -> tuple[str, list[str]]:
    changes: list[str] = []
    text = "\n".join(_without_tabs(line, changes) for line in code.split("\n"))
    for what, rewrite in _REWRITES:
        new = rewrite(text)
        if new != text:
            changes.append(what)
            text = new
    return text, changes


def _without_tabs(line: str, changes: list[str]) -> str:
    """Return a line whose indentation has no tabs; Python 2 lets a tab lead to the next multiple of 8."""
    body = line.lstrip(" \t")
    indentation = line[: len(line) - len(body)]
    if "\t" in indentation:
        changes.append("tabs in indentation")
    return indentation.expandtabs(8) + body


def _tokens(code: str) -> list[tokenize.TokenInfo]:
    try:
        return list(tokenize.generate_tokens(io.StringIO(code).readline))
    except (tokenize.TokenError, IndentationError) as error:
        raise SyntaxError(str(error)) from error


def _statements(tokens: list[tokenize.TokenInfo]) -> Iterator[list[tokenize.TokenInfo]]:
    """Yield the tokens of each simple statement; what introduces a block ends at its colon."""
    statement: list[tokenize.TokenInfo] = []
    depth = 0
    for token in tokens:
        if token.type in (tokenize.COMMENT, tokenize.NL, tokenize.INDENT, tokenize.DEDENT):
            continue
        depth += (token.string in "([{") - (token.string in ")]}") if token.type == tokenize.OP else 0
        if token.type in (tokenize.NEWLINE, tokenize.ENDMARKER) or (
            depth == 0 and token.string in (";", ":")
        ):
            if statement:
                yield statement
            statement = []
        else:
            statement.append(token)


def _replaced(code: str, edits: list[tuple[tuple[int, int], tuple[int, int], str]]) -> str:
    lines = code.split("\n")
    for (first, start), (last, end), text in sorted(edits, reverse=True):
        tail = lines[last - 1][end:]
        lines[first - 1] = lines[first - 1][:start] + text + (tail if first == last else "")
        if first != last:
            lines[last - 1] = tail
    return "\n".join(lines)


def _print_statements(code: str) -> str:
    edits: list[tuple[tuple[int, int], tuple[int, int], str]] = []
    for statement in _statements(_tokens(code)):
        head = statement[0]
        if head.string != "print" or head.type != tokenize.NAME or _is_call(statement[1:]):
            continue
        edits += _print_call(statement)
    return _replaced(code, edits)


def _is_call(rest: list[tokenize.TokenInfo]) -> bool:
    """Return whether what follows ``print`` is one pair of parentheses, or an assignment and the like."""
    if not rest:
        return False
    if rest[0].string != "(":
        return rest[0].string in ("=", ".", ",")
    depth = 0
    for i, token in enumerate(rest):
        depth += (token.string in ("(", "[", "{")) - (token.string in (")", "]", "}"))
        if depth == 0:
            return i == len(rest) - 1
    return True


def _print_call(statement: list[tokenize.TokenInfo]) -> list[tuple[tuple[int, int], tuple[int, int], str]]:
    head, *rest = statement
    if not rest:
        return [(head.end, head.end, "()")]
    last, more = rest[-1], ""
    begin, opening = head.end, "("
    if rest[0].string == ">>":
        comma = next((token for token in rest if token.string == ","), None)
        stream = "".join(token.string for token in rest[1 : rest.index(comma) if comma else None])
        more, begin = f", file={stream}", comma.end if comma else last.end
        if comma is None:
            return [(head.end, last.end, f"(file={stream})")]
    if last.string == ",":
        edits = [(last.start, last.end, f", end=' '{more})")]
    else:
        edits = [(last.end, last.end, f"{more})")]
    return [(head.end, begin if more else (head.end[0], rest[0].start[1]) if rest[0].start[0] == head.end[0]
             else head.end, opening), *edits]  # fmt: skip


def _exceptions(code: str) -> str:
    code = re.sub(
        r"^(\s*except\s+[\w.]+|\s*except\s*\([^)]*\))\s*,\s*(\w+)\s*:", r"\1 as \2:", code, flags=re.M
    )
    return re.sub(r"^(\s*raise\s+[\w.]+)\s*,\s*(.+?)\s*$", r"\1(\2)", code, flags=re.M)


def _operators(code: str) -> str:
    code = re.sub(r"(?<=[\w)\] ])<>(?=[\w( ])", "!=", code)
    code = re.sub(r"(?<![\w.'\"])0(?=[0-7]+\b)(?!\d*\.)", "0o", code)
    return re.sub(r"\b(\d+)[lL]\b", r"\1", code)


_REWRITES: tuple[tuple[str, Callable[[str], str]], ...] = (
    ("except and raise", _exceptions),
    ("operators and literals", _operators),
    ("print statements", _print_statements),
)


# -- by what the code means


class _Division(ast.NodeTransformer):
    def __init__(self, changes: list[str]) -> None:
        self._changes = changes

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        if not isinstance(node.op, ast.Div) or _is_real(node.left) or _is_real(node.right):
            return node
        self._changes.append("integer division")
        call = ast.Call(ast.Name(DIVIDE, ast.Load()), [node.left, node.right], [])
        return ast.copy_location(call, node)


def _is_real(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, float)


class _Methods(ast.NodeTransformer):
    def __init__(self, changes: list[str]) -> None:
        self._changes = changes

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        method = node.func
        if not isinstance(method, ast.Attribute):
            return node
        if method.attr in _METHODS and not node.args:
            self._changes.append(f"{method.attr}()")
            method.attr = _METHODS[method.attr]
        elif method.attr == "has_key" and len(node.args) == 1:
            self._changes.append("has_key()")
            return ast.copy_location(ast.Compare(node.args[0], [ast.In()], [method.value]), node)
        return node


def refusal(error: SyntaxError, path: object, first_line: int) -> TransferFunctionError:
    """Return what is said of code that cannot be converted."""
    line = (error.lineno or 1) + first_line - 1
    return TransferFunctionError(
        f"this is neither Python 3 nor Python 2: {error.msg}", path=str(path), line=line
    )
