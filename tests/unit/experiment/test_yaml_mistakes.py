"""Text that is not YAML is refused at the line that is wrong, without the words of a parser."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.section import Place
from nrp_core.experiment.reading.yaml_tree import parse_tree

FILE = """\
name: a
brain:
  backend: event
  model: brain.py
  populations: {sensors: "0:5", actors: "6:8"}
list:
  - one
  - two
text: "quoted"
"""
MISTAKES = {
    "a tab": ("  model", "\tmodel", 4, "a tab, where YAML takes only spaces"),
    "a tab behind a value": ("event", "event\t", 3, "a tab"),
    "a line too far": ("  model", "    model", 4, "a key where the value of the line above goes on"),
    "a line not far enough": ("  model", " model", 4, "indented by 1 space, which fits no line above"),
    "the first line too far": ("  backend", "   backend", 4, "indented by 2 spaces, which fits no line"),
    "no colon": ("model:", "model", 4, "expected 'key: value', with a space after the colon"),
    "no space after a colon": ("model: ", "model:", 4, "expected 'key: value'"),
    "=": ("model: ", "model = ", 4, "expected 'key: value'"),
    "a second colon": ("brain.py", "brain: py", 4, "a second ': ' in one value"),
    "[ without ]": ('"0:5"', '["0:5"', 5, "the list in [ ] that begins in line 5 lacks a comma or its end"),
    "{ without }": ('"6:8"}', '"6:8"', 6, "the mapping in { } that begins in line 5 lacks a comma"),
    "no comma": (", actors", " actors", 5, "the mapping in { } that begins in line 5 lacks a comma"),
    "a quote without its end": ('"quoted"', '"quoted', 9, "a quoted text begins here and does not end"),
    "more behind a quote": ('"quoted"', '"quo"ted"', 9, "there is more behind the end of a value"),
    "an item among keys": (
        "  model: brain.py",
        "  - model",
        4,
        "where the mapping that begins in line 3 has",
    ),
    "a key among items": ("  - two", "  two: 2", 8, "a key, where the list that begins in line 7 has items"),
    "@": ("brain.py", "@brain", 4, "a text that begins with @ needs quotes"),
    "*": ("brain.py", "*brain", 4, "there is no anchor '&brain' for '*brain'"),
    "|": ("brain.py", "|x", 4, "a text that begins with | or > needs quotes"),
    "a Windows path": ('"quoted"', r'"C:\data"', 9, r"'\d' has no meaning in double quotes"),
    "two documents": ("text:", "---\ntext:", 9, "a second document begins here"),
    "a bell": ("event", "ev\x07ent", 3, "the character U+0007 is not allowed"),
    "an anchor twice": ("event\n  model: ", "&a event\n  model: &a ", 4, "the anchor '&a' is given twice"),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("mistake", MISTAKES)
def test_the_line_and_what_is_wrong_with_it_are_named(mistake: str) -> None:
    old, new, line, words = MISTAKES[mistake]
    assert FILE.count(old) == 1
    with pytest.raises(ExperimentError) as caught:
        parse_tree(FILE.replace(old, new), Place(Path("file.yaml")))
    assert caught.value.line == line
    assert words in str(caught.value)
    assert "while" not in str(caught.value)


def test_an_anchor_can_be_used_often_and_given_once() -> None:
    tree = parse_tree(FILE.replace("event", "&a event").replace('"quoted"', "[*a, *a]"), Place())
    assert tree.plain()["text"] == ["event", "event"]
