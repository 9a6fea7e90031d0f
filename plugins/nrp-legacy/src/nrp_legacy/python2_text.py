"""Convert the text of Python 2 to Python 3 by lines and tokens; line numbers do not change."""

from __future__ import annotations

import io
import re
import tokenize
from collections.abc import Callable, Iterator
from itertools import pairwise

Edit = tuple[tuple[int, int], tuple[int, int], str]
Token = tokenize.TokenInfo


def rewritten(code: str) -> tuple[str, list[str]]:
    """Return code as text for Python 3, and the changes; divisions and methods stay.

    Raises:
        SyntaxError: it cannot be tokenised.
    """
    changes: list[str] = []
    text = "\n".join(_without_tabs(line, changes) for line in code.split("\n"))
    for what, edits in _REWRITES:
        new = _replaced(text, list(edits(_tokens(text))))
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


def _tokens(code: str) -> list[Token]:
    try:
        return list(tokenize.generate_tokens(io.StringIO(code).readline))
    except (tokenize.TokenError, IndentationError) as error:
        raise SyntaxError(str(error)) from error


def _statements(tokens: list[Token]) -> Iterator[list[Token]]:
    """Yield the tokens of each simple statement; the head of a block ends at its colon."""
    statement: list[Token] = []
    depth = 0
    for token in tokens:
        if token.type in (tokenize.COMMENT, tokenize.NL, tokenize.INDENT, tokenize.DEDENT):
            continue
        depth += _nesting(token)
        if token.type in (tokenize.NEWLINE, tokenize.ENDMARKER) or (
            depth == 0 and token.string in (";", ":")
        ):
            if statement:
                yield statement
            statement = []
        else:
            statement.append(token)


def _nesting(token: Token) -> int:
    return (token.string in "([{") - (token.string in ")]}") if token.type == tokenize.OP else 0


def _outermost(tokens: list[Token], text: str) -> list[Token]:
    """Return the tokens of a text outside parentheses."""
    depth, found = 0, []
    for token in tokens:
        depth += _nesting(token)
        found += [token] if depth == 0 and token.string == text else []
    return found


def _replaced(code: str, edits: list[Edit]) -> str:
    lines = code.split("\n")
    for (first, start), (last, end), text in sorted(edits, reverse=True):
        tail = lines[last - 1][end:]
        lines[first - 1] = lines[first - 1][:start] + text + (tail if first == last else "")
        if first != last:
            lines[last - 1] = tail
    return "\n".join(lines)


# -- operators and literals


def _operators(tokens: list[Token]) -> Iterator[Edit]:
    quotes = [token for token in tokens if token.string == "`"]
    for opening, closing in zip(quotes[::2], quotes[1::2], strict=False):
        yield opening.start, opening.end, "repr("
        yield closing.start, closing.end, ")"
    for one, after in pairwise(tokens):
        if (
            one.string == "<>"
        ):  # Python 3.12 and newer make one token of it, and of a number that begins with 0
            yield one.start, one.end, "!="
        elif one.type == tokenize.NUMBER and re.fullmatch("0+[1-9][0-9]*", one.string):
            yield one.start, one.end, f"0o{one.string}"
        if one.end != after.start:
            continue
        if (one.string, after.string) == ("<", ">"):
            yield one.start, after.end, "!="
        elif one.type == tokenize.NUMBER and after.type == tokenize.NUMBER and re.fullmatch("0+", one.string):
            yield one.start, after.start, "0o"
        elif one.type == tokenize.NUMBER and after.string in ("l", "L"):
            yield after.start, after.end, ""
        elif one.string.lower() == "ur" and after.type == tokenize.STRING:
            yield one.start, one.end, "r"


# -- parameters in parentheses


def _lambdas(tokens: list[Token]) -> Iterator[Edit]:
    """Convert ``lambda (a, b): a``, which takes a pair: ``lambda _pair: (lambda a, b: a)(*_pair)``."""
    said = [token for token in tokens if token.type not in (tokenize.COMMENT, tokenize.NL)]
    for i, (word, opening) in enumerate(pairwise(said)):
        if (word.string, opening.string) != ("lambda", "("):
            continue
        closing = next((k for k in range(i + 1, len(said)) if said[k].string == ")"), i)
        if said[closing + 1].string != ":":
            continue
        is_one = all(token.string != "," for token in said[i:closing])
        yield opening.start, opening.end, " " if is_one else "_pair: (lambda "
        yield said[closing].start, said[closing].end, ""
        if is_one:
            continue
        last = said[_end_of_lambda(said, closing + 2) - 1]
        yield last.end, last.end, ")(*_pair)"


def _end_of_lambda(tokens: list[Token], first: int) -> int:
    """Return the index behind the body of a lambda."""
    depth = 0
    for k in range(first, len(tokens)):
        depth += _nesting(tokens[k])
        is_over = depth == 0 and tokens[k].string in (",", ":", ";", "for")
        if depth < 0 or is_over or tokens[k].type == tokenize.NEWLINE:
            return k
    return len(tokens)


# -- lists in comprehensions


def _comprehensions(tokens: list[Token]) -> Iterator[Edit]:
    """Convert ``[x for x in 1, 2]``, which iterates over a tuple."""
    said = [token for token in tokens if token.type not in (tokenize.COMMENT, tokenize.NL)]
    for i, token in enumerate(said):
        if token.string == "in" and _is_in_list(said[:i]):
            end = _end_of_items(said, i + 1)
            if _outermost(said[i + 1 : end], ","):
                yield said[i + 1].start, said[i + 1].start, "("
                yield said[end - 1].end, said[end - 1].end, ")"


def _is_in_list(before: list[Token]) -> bool:
    """Return whether the items of a comprehension in ``[]`` begin after some tokens."""
    depth, is_loop = 0, False
    for token in reversed(before):
        depth -= _nesting(token)
        if depth < 0:
            return is_loop and token.string == "["
        if depth == 0 and token.string in ("for", "in", "if", "else"):
            if not is_loop and token.string != "for":
                return False
            is_loop = True
    return False


def _end_of_items(tokens: list[Token], first: int) -> int:
    """Return the index after the items of a comprehension."""
    depth = 0
    for k in range(first, len(tokens)):
        depth += _nesting(tokens[k])
        if depth < 0 or (depth == 0 and tokens[k].string in ("for", "if")):
            return k
    return len(tokens)


# -- statements


def _exceptions(tokens: list[Token]) -> Iterator[Edit]:
    for statement in _statements(tokens):
        head, last = statement[0], statement[-1]
        commas = _outermost(statement, ",")
        if head.type != tokenize.NAME or not commas:
            continue
        if head.string == "except":
            yield commas[-1].start, commas[-1].end, " as"
        elif head.string == "raise":
            yield commas[0].start, commas[0].end, "("
            yield from ((comma.start, comma.end, ").with_traceback(") for comma in commas[1:2])
            yield last.end, last.end, ")"


def _exec_statements(tokens: list[Token]) -> Iterator[Edit]:
    for statement in _statements(tokens):
        head, *rest = statement
        if head.string != "exec" or not rest:
            continue
        places = _outermost(rest, "in")
        if rest[0].string == "(" and not places:
            continue
        yield head.end, head.end, "("
        yield rest[-1].end, rest[-1].end, ")"
        yield from ((place.start, place.end, ",") for place in places[:1])


def _print_statements(tokens: list[Token]) -> Iterator[Edit]:
    for statement in _statements(tokens):
        head = statement[0]
        if head.string == "print" and head.type == tokenize.NAME and not _is_call(statement[1:]):
            yield from _print_call(statement)


def _is_call(rest: list[Token]) -> bool:
    """Return whether ``print`` is followed by one pair of parentheses, an assignment or similar."""
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


def _print_call(statement: list[Token]) -> list[Edit]:
    head, *rest = statement
    if not rest:
        return [(head.end, head.end, "()")]
    last, more = rest[-1], ""
    begin, opening = head.end, "("
    if rest[0].string == ">>":
        comma = next(iter(_outermost(rest, ",")), None)
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


_REWRITES: tuple[tuple[str, Callable[[list[Token]], Iterator[Edit]]], ...] = (
    ("operators and literals", _operators),
    ("parameters in parentheses", _lambdas),
    ("comprehensions", _comprehensions),
    ("except and raise", _exceptions),
    ("exec statements", _exec_statements),
    ("print statements", _print_statements),
)
