from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import SceneError
from nrp_core.world.scene.reading.xml import Element, parse_xml, read_xml

FILE = Path("robot.sdf")


def parse(text: str) -> Element:
    return parse_xml(text.encode(), FILE)


def test_every_element_knows_its_line() -> None:
    root = parse("<a>\n  <b\n   x='1'/>\n  <c>\n<d/></c></a>")
    assert [e.line for e in (root, *root.children, root.children[1].children[0])] == [1, 2, 4, 5]
    assert root.children[0].where == "robot.sdf:2"


def test_text_is_stripped_and_joined_around_children() -> None:
    root = parse("<a> 1 <b>2</b> 3 </a>")
    assert root.text.split() == ["1", "3"]
    assert root.require("b").text == "2"


def test_a_byte_order_mark_and_windows_line_ends_are_read() -> None:
    root = parse_xml(b"\xef\xbb\xbf<a>\r\n<b/>\r\n</a>", FILE)
    assert root.children[0].line == 2


def test_blanks_before_the_declaration_are_forgiven() -> None:
    root = parse(" \n\n<?xml version='1.0'?>\n<a/>")
    assert (root.tag, root.line) == ("a", 4)


@pytest.mark.parametrize(
    "declaration", ["", "<?xml version='1.0'?>", "<?xml version='1.0' encoding='UTF-8'?>"]
)
def test_latin_1_that_is_not_declared_is_read(declaration: str) -> None:
    text = f"{declaration}<!-- \N{DEGREE SIGN} --><a b='\N{LATIN SMALL LETTER U WITH DIAERESIS}'/>"
    assert (
        parse_xml(text.encode("latin-1"), FILE).attributes["b"] == "\N{LATIN SMALL LETTER U WITH DIAERESIS}"
    )
    assert parse_xml(text.encode(), FILE).attributes["b"] == "\N{LATIN SMALL LETTER U WITH DIAERESIS}"


@pytest.mark.parametrize("encoding", ["utf-16", "iso-8859-1"])
def test_declared_encodings_are_read(encoding: str) -> None:
    text = f"<?xml version='1.0' encoding='{encoding}'?><a>\N{LATIN SMALL LETTER U WITH DIAERESIS}</a>"
    assert parse_xml(text.encode(encoding), FILE).text == "\N{LATIN SMALL LETTER U WITH DIAERESIS}"


@pytest.mark.parametrize("text", ["", "<a>", "<a></b>", "<a/><b/>", "<a b=1/>", "no xml", "<a>&nothing;</a>"])
def test_what_is_not_well_formed_is_refused_with_its_line(text: str) -> None:
    with pytest.raises(SceneError, match="not well-formed") as refusal:
        parse(text)
    assert refusal.value.line == 1


@pytest.mark.parametrize(
    "doctype",
    [
        '<!DOCTYPE a [<!ENTITY x "xxxx"><!ENTITY y "&x;&x;&x;">]><a>&y;</a>',
        '<!DOCTYPE a [<!ENTITY secret SYSTEM "file:///etc/passwd">]><a>&secret;</a>',
        '<!DOCTYPE a SYSTEM "http://example.org/a.dtd"><a/>',
    ],
)
def test_document_types_are_refused_before_an_entity_is_expanded(doctype: str) -> None:
    with pytest.raises(SceneError, match="DOCTYPE"):
        parse(doctype)


def test_nesting_without_end_is_refused() -> None:
    with pytest.raises(SceneError, match="nested more than 100 deep"):
        parse("<a>" * 5000 + "</a>" * 5000)


@given(st.binary(max_size=60))
def test_arbitrary_bytes_are_read_or_refused_but_never_crash(data: bytes) -> None:
    with suppress(SceneError):
        assert parse_xml(data, FILE).path == FILE


def test_numbers_are_read() -> None:
    root = parse("<a><v> 1 -2e3  .5\n</v><n>3</n><inf>-inf</inf></a>")
    assert root.require("v").numbers(3) == (1, -2000, 0.5)
    assert root.number("n", 7) == 3
    assert root.number("missing", 7) == 7
    assert root.number("inf", 0, finite=False) == -float("inf")


@pytest.mark.parametrize(
    "text", ["", "1 2", "one", "1,2,3", "nan nan nan", "inf 0 0", "1e31 0 0", "0x10 0 0"]
)
def test_what_are_not_three_finite_numbers_is_refused_with_what_stands_there(text: str) -> None:
    element = parse(f"<a>\n<v>{text}</v></a>").require("v")
    with pytest.raises(SceneError, match=text or "''") as refusal:
        element.numbers(3)
    assert str(refusal.value).startswith("robot.sdf:2: <v> must ")


@pytest.mark.parametrize("text", ["0", "-1", "0.0"])
def test_sizes_are_more_than_zero(text: str) -> None:
    with pytest.raises(SceneError, match="more than 0"):
        parse(f"<a><radius>{text}</radius></a>").positive("radius")


def test_a_size_without_a_default_must_be_there() -> None:
    assert parse("<a/>").positive("radius", 2.0) == 2
    with pytest.raises(SceneError, match="<a> needs a <radius>"):
        parse("<a/>").positive("radius")


@pytest.mark.parametrize(
    ("text", "value"), [("1", True), ("true", True), ("True", True), ("0", False), ("FALSE", False)]
)
def test_flags_are_words_or_digits(text: str, value: bool) -> None:
    assert parse(f"<a><static>{text}</static></a>").flag("static", not value) is value


def test_a_flag_that_is_neither_says_what_would_be_valid() -> None:
    with pytest.raises(SceneError, match="<static> is 'yes'; valid: 0, 1, false, true"):
        parse("<a><static>yes</static></a>").flag("static", False)


def test_directions_have_length_one() -> None:
    assert parse("<a><xyz>0 3 4</xyz></a>").direction("xyz", (0, 0, 1)) == (0, 0.6, 0.8)
    with pytest.raises(SceneError, match="no direction"):
        parse("<a><xyz>0 0 0</xyz></a>").direction("xyz", (0, 0, 1))


def test_an_attribute_that_is_needed_is_named() -> None:
    assert parse("<a name=' x '/>").attribute("name") == "x"
    with pytest.raises(SceneError, match=r'<a> needs an attribute name="\.\.\."'):
        parse("<a name=''/>").attribute("name")


def test_a_missing_file_is_named_with_one_that_is_there(tmp_path: Path) -> None:
    (tmp_path / "husky.sdf").touch()
    with pytest.raises(SceneError, match=r"there is no file .*huski\.sdf; did you mean 'husky\.sdf'"):
        read_xml(tmp_path / "huski.sdf")
    with pytest.raises(SceneError, match="there is no folder"):
        read_xml(tmp_path / "nowhere" / "husky.sdf")


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot read"):
        read_xml(tmp_path)
