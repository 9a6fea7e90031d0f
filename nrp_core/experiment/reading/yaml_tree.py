"""YAML text to a :class:`~nrp_core.experiment.model.section.Tree`: safe types only, each with its place."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.reader import ReaderError

from nrp_core._support.text import misfit
from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.section import Place, Tree

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


def explain_error(error: MarkedYAMLError, text: str) -> tuple[str, Any]:
    """Return the mistake in a text, and the mark of its place or None."""
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
    """Return the mistake in a text with a character that YAML does not allow, and its line."""
    return f"the character {_name(error.character)} is not allowed", text.count("\n", 0, error.position) + 1


def _name(character: Any) -> str:
    return f"U+{character if isinstance(character, int) else ord(character):04X}"


def _by_place(error: MarkedYAMLError, problem: str, text: str) -> str:
    """Return the mistake in the structure of a text; empty if none is recognized."""
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


_YAML = "tag:yaml.org,2002:"
MAX_VALUES = 100_000
"""Maximum number of values, with each use of an alias counted, against malicious files."""


def read_tree(path: Path, what: str = "an experiment") -> Tree:
    """Read a YAML file.

    Args:
        path: the file.
        what: the whole file, in messages.

    Raises:
        ExperimentError: it cannot be read, is not YAML, uses a key twice, or holds no mapping.
    """
    try:
        data = path.read_bytes()
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        found = misfit(data, error)
        raise ExperimentError(found.message, path=path, line=found.line, column=found.column) from error
    except OSError as error:
        raise ExperimentError(f"cannot be read: {error.strerror}", path=path) from error
    tree = known_tree(text, Place(path))
    if not isinstance(tree.value, dict):
        raise ExperimentError(f"{what} is a mapping: 'key: value' and so on", path=path, line=1, column=1)
    return tree


def parse_tree(text: str, place: Place) -> Tree:
    """Parse YAML text; ``place`` is its file or override.

    Raises:
        ExperimentError: it is not YAML, or uses a key twice.
    """
    yaml = YAML(typ="safe", pure=True)
    yaml.composer.warn_double_anchors = False  # they are refused
    try:
        node = yaml.compose(text)
        return Tree(None, place) if node is None else _Builder(yaml, place).tree(node)
    except ExperimentError:
        raise
    except MarkedYAMLError as error:
        what, mark = explain_error(error, text)
        at = place if mark is None or place.path is None else _place(place, mark)
        raise at.error(f"not YAML: {what}") from error
    except ReaderError as error:
        what, line = unreadable(error, text)
        raise (place if place.path is None else Place(place.path, line)).error(f"not YAML: {what}") from error
    except (YAMLError, ValueError) as error:
        raise place.error(f"not YAML: {str(error).splitlines()[0]}") from error
    except RecursionError as error:
        raise place.error("nested too deeply") from error


known_tree = lru_cache(512)(parse_tree)
"""Files and overrides are read again for every run of a sweep; users of this tree do not change it."""


def _place(place: Place, mark: Any) -> Place:
    return Place(place.path, mark.line + 1, mark.column + 1)


def _is_missing(node: Node) -> bool:
    """Return whether a value is missing or consists only of comments."""
    return isinstance(node, ScalarNode) and node.value == "" and str(node.tag) == f"{_YAML}null"


class _Builder:
    def __init__(self, yaml: YAML, place: Place) -> None:
        self._yaml, self._place = yaml, place
        self._values = 0
        self._open: list[Node] = []
        self._anchors: dict[str, Node] = {}

    def tree(self, node: Node) -> Tree:
        place = self._place_of(node)
        self._values += 1
        if self._values > MAX_VALUES or any(node is outer for outer in self._open):
            raise place.error("aliases make this value endless")
        if node.anchor and self._anchors.setdefault(node.anchor, node) is not node:
            raise place.error(f"the anchor '&{node.anchor}' is given twice")
        tag = str(node.tag)
        if not tag.startswith(_YAML) or "/" in tag.removeprefix(_YAML):
            raise place.error(f"the tag '{tag.replace(_YAML, '!!')}' has no meaning here")
        self._open.append(node)
        value: Any
        if isinstance(node, MappingNode):
            value = self._mapping(node)
        elif isinstance(node, SequenceNode):
            value = [self.tree(item) for item in node.value]
        else:
            value = self._scalar(node)
        self._open.pop()
        return Tree(value, place)

    def _scalar(self, node: Node) -> Any:
        if str(node.tag).removeprefix(_YAML) in ("timestamp", "value", "str"):  # a date is a name here
            return str(node.value)
        return self._yaml.constructor.construct_object(node)

    def _mapping(self, node: MappingNode) -> dict[str, Tree]:
        own: dict[str, Tree] = {}
        inherited: dict[str, Tree] = {}
        for key_node, value_node in node.value:
            place = self._place_of(key_node)
            if key_node.tag == f"{_YAML}merge":
                inherited = {**self._merge_sources(value_node), **inherited}
            elif not isinstance(key_node, ScalarNode):
                raise place.error("a key is a text")
            elif key_node.value in own:
                raise place.error(f"the key '{key_node.value}' is given twice")
            elif _is_missing(value_node):
                raise place.error(
                    f"the key '{key_node.value}' has no value; 'null' removes what is inherited"
                )
            else:
                own[key_node.value] = replace(self.tree(value_node), key_place=place)
        return {**inherited, **own}

    def _merge_sources(self, node: Node) -> dict[str, Tree]:
        sources = [self.tree(source) for source in (node.value if isinstance(node, SequenceNode) else [node])]
        merged: dict[str, Tree] = {}
        for source in sources:
            if not isinstance(source.value, dict):
                raise source.place.error("'<<' takes a mapping or a list of mappings")
            merged = {**source.value, **merged}
        return merged

    def _place_of(self, node: Node) -> Place:
        return self._place if self._place.path is None else _place(self._place, node.start_mark)
