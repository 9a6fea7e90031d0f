"""Say what is wrong with a text that is not YAML, without the words of a parser."""

from __future__ import annotations

import re
from typing import Any

from ruamel.yaml.error import MarkedYAMLError
from ruamel.yaml.reader import ReaderError

_NEEDS_QUOTES = "a text that begins with {} needs quotes"
_PLAIN = (
    (r"found character '\\t'", "a tab, where YAML takes only spaces"),
    (r"found character '(.)' that cannot start", _NEEDS_QUOTES),
    (r"unknown escape character '(.)'", r"'\{}' has no meaning in double quotes; use single quotes"),
    (r"expected chomping or indentation indicators", _NEEDS_QUOTES.format("| or >")),
    (r"expected alphabetic or numeric character", _NEEDS_QUOTES.format("* or &")),
    (r"found undefined alias '(.*)'", "there is no anchor '&{0}' for '*{0}'; " + _NEEDS_QUOTES.format("*")),
    (r"but found another document", "a second document begins here; a file has one"),
    (r"expected the node content", "a list in [ ] or a mapping in {{ }} is not complete"),
)
"""Problems that need no context: a pattern of the parser's words, and our words."""
_OPENED = (
    (r"could not find expected ':'", "expected 'key: value', with a space after the colon, or '- item'"),
    (r"unexpected (end of stream|document separator)", "a quoted text begins here and does not end"),
)
"""Problems that the parser notices later than where they are."""


def explained(error: MarkedYAMLError, text: str) -> tuple[str, Any]:
    """Return what is wrong with a text, and the mark of its place; None: it has no place."""
    mark = error.problem_mark or error.context_mark
    problem = f"{error.context or ''} {error.problem}"
    for pattern, words in _OPENED:
        if re.search(pattern, problem):
            return words, error.context_mark or mark
    for pattern, words in _PLAIN:
        if found := re.search(pattern, problem):
            return words.format(*found.groups()), mark
    return _by_place(error, problem, text) or problem.strip(), mark


def unreadable(error: ReaderError, text: str) -> tuple[str, int]:
    """Return what is wrong with a text that has a character which YAML does not allow, and its line."""
    return f"the character {_name(error.character)} is not allowed", text.count("\n", 0, error.position) + 1


def _name(character: Any) -> str:
    return f"U+{character if isinstance(character, int) else ord(character):04X}"


def _by_place(error: MarkedYAMLError, problem: str, text: str) -> str:
    """Return what is wrong with the structure of a text; empty: nothing that is known here."""
    mark, begin = error.problem_mark, error.context_mark
    if mark is None:
        return ""
    line = text.split("\n")[mark.line]
    if "mapping values are not allowed" in problem:
        if ": " in line[: mark.column]:
            return "a second ': ' in one value; a text with ': ' needs quotes"
        return (
            "a key where the value of the line above goes on: that line lacks its ':', or this one is "
            "indented too far"
        )
    if begin is None:
        return ""
    if "expected ',' or" in problem:
        kind = "list in [ ]" if "]'" in problem else "mapping in { }"
        return f"the {kind} that begins in line {begin.line + 1} lacks a comma or its end"
    if "expected <block end>" in problem:
        return _in_block(line[: mark.column], problem, mark.column, begin)
    return ""


def _in_block(before: str, problem: str, column: int, begin: Any) -> str:
    if before.strip():
        return "there is more behind the end of a value"
    if column != begin.column:
        spaces = f"{column} space{'s' * (column != 1)}"
        return f"indented by {spaces}, which fits no line above that it could belong to"
    if problem.endswith("'-'"):
        return f"an item '- ...', where the mapping that begins in line {begin.line + 1} has keys"
    return f"a key, where the list that begins in line {begin.line + 1} has items '- ...'"
