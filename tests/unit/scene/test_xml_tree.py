from __future__ import annotations

import socket
from contextlib import suppress
from pathlib import Path

import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from nrp_core.errors import SceneError
from nrp_core.scene.reading.context import Element, parse_xml, read_xml
from nrp_core.xml import strict_xml

FILE = Path("robot.sdf")


def parse(text: str) -> Element:
    return parse_xml(text.encode(), FILE)


def test_every_element_knows_its_line() -> None:
    root = parse("<a>\n  <b\n   x='1'/>\n  <c>\n<d/></c></a>")
    assert [e.line for e in (root, *root.children, root.children[1].children[0])] == [1, 2, 4, 5]
    assert root.children[0].where == "robot.sdf:2"


def test_every_element_knows_the_line_on_which_it_ends() -> None:
    root = parse("<a>\n<b\n x='>'\n/><c>\n</c\n><!-- </a>\n --><![CDATA[</a>\n]]><?no </a>\n?>\n</a>")
    assert [(e.line, e.end_line) for e in (root, *root.children)] == [(1, 10), (2, 4), (4, 5)]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_are_counted_beyond_what_libxml2_counts(end: str) -> None:
    root = parse(f"<a>{end * 70_000}<b/>{end * 70_000}<c>{end}</c></a>")
    assert [(e.line, e.end_line) for e in root.children] == [(70_001, 70_001), (140_001, 140_002)]


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


def test_the_version_does_not_matter() -> None:
    assert parse("<?xml\nversion='0.0' ?>\n<a/>").line == 3  # as in URDF files of PyBullet


@pytest.mark.parametrize(
    "declaration", ["", "<?xml version='1.0'?>", "<?xml version='1.0' encoding='UTF-8'?>"]
)
def test_latin_1_that_is_not_declared_is_read(declaration: str) -> None:
    text = f"{declaration}<!-- \N{DEGREE SIGN} --><a b='\N{LATIN SMALL LETTER U WITH DIAERESIS}'/>"
    assert (
        parse_xml(text.encode("latin-1"), FILE).attributes["b"] == "\N{LATIN SMALL LETTER U WITH DIAERESIS}"
    )
    assert parse_xml(text.encode(), FILE).attributes["b"] == "\N{LATIN SMALL LETTER U WITH DIAERESIS}"


@pytest.mark.parametrize("blanks", ["", " \n"])
@pytest.mark.parametrize("encoding", ["utf-16", "iso-8859-1", "cp1252", "gb18030"])
def test_declared_encodings_are_read(encoding: str, blanks: str) -> None:
    text = (
        f"{blanks}<?xml version='1.0' encoding='{encoding}'?><a>\N{LATIN SMALL LETTER U WITH DIAERESIS}</a>"
    )
    assert parse_xml(text.encode(encoding), FILE).text == "\N{LATIN SMALL LETTER U WITH DIAERESIS}"


@pytest.mark.parametrize("codec", ["no-such", "rot13", "punycode", "utf-16"])
def test_an_encoding_that_is_not_that_of_the_document_is_refused(codec: str) -> None:
    hostile = f"<?xml version='1.0' encoding='{codec}'?>-{'a' * 1_000_000}"  # punycode would take a minute
    with pytest.raises(SceneError, match=f"(?s)encoding.*{codec}|not in {codec}"):
        parse(hostile)


def test_a_byte_outside_the_declared_encoding_is_refused_with_its_line(golden: Golden) -> None:
    with golden.raises(SceneError) as refusal:
        parse_xml(b"<?xml version='1.0' encoding='ascii'?>\n<a>\n\xfc</a>", FILE)
    assert refusal.value.line == 3


def test_end_tags_after_the_root_are_ignored_as_in_mujoco_and_gazebo() -> None:
    root = parse("<a>\n<b/>\n</a>\n </a>\n</b>\n")
    assert (root.end_line, [child.tag for child in root.children]) == (3, ["b"])


@pytest.mark.parametrize("rest", ["<b/>", "<b></b></a>", "x</a>", "</a><b/>", "<!-- </a>", "<![CDATA[</a>"])
def test_other_content_after_the_root_is_refused(rest: str) -> None:
    with pytest.raises(SceneError) as refusal:
        parse(f"<a>\n</a>\n{rest}")
    assert refusal.value.line == 3


COMMENTS = ["<!-- x --->", "<!---->", "<!---- x ---->", "<!-- a -- b -->", "<!--> x -->", "<!-- \x0c -->"]


@pytest.mark.parametrize("comment", [*COMMENTS, "<!-- -\n--\n--->", "<!-- <b> <![CDATA[ <?no -->"])
def test_comments_end_at_the_first_end_and_hide_nothing_behind_them(comment: str) -> None:
    root = parse(f"<!-- - -->{comment}<a>1{comment}2<b>{comment}</b>\n<c/></a>{comment}")
    lines = comment.count("\n")
    assert (root.raw_text, root.line) == ("12\n", 1 + lines)
    assert [(e.tag, e.line, e.end_line) for e in root.children] == [
        ("b", 1 + 2 * lines, 1 + 3 * lines),
        ("c", 2 + 3 * lines, 2 + 3 * lines),
    ]


@pytest.mark.parametrize(
    "text", ["<a><!-- </a>", "<a/><!--->", "<a><!-- --> --></b>", "<a b='<!-- -- -->'/>"]
)
def test_a_comment_forgives_nothing_around_it(text: str, golden: Golden) -> None:
    with golden.raises(SceneError):
        parse(text)


@pytest.mark.parametrize("comment", COMMENTS)
def test_text_in_cdata_that_looks_like_a_comment_is_text(comment: str) -> None:
    comment = comment.replace("\x0c", "")
    assert parse(f"<a><?no {comment}?><![CDATA[{comment}]]><!-- --></a>").text == comment


PLACE = "<!--place-->"
NAMES = st.sampled_from(["a", "b", "x:c"])
TEXTS = st.text("1 <>&'\"-\n\r\t\u00fc", max_size=6)
COMMENT_TEXTS = st.lists(
    st.sampled_from([" ", "-x", "\n", "\r\n", "<b>", "]]>", "<?", "\u00fc", "&"]), max_size=4
)
MARKUP = st.one_of(
    TEXTS.map(lambda text: text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")),
    TEXTS.map(lambda text: f"<![CDATA[{text.replace(']]>', '')}<!-- x --->]]>"),
    COMMENT_TEXTS.map(lambda parts: f"<!--{''.join(parts)}-->"),
    st.sampled_from(["<?no <!-- x --->?>", "&#13;&#10;", PLACE, PLACE]),
)


def element(name: str, value: str, inside: list[str]) -> str:
    quoted = value.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    start = f'<{name} xmlns:x="u" v="{quoted}"'
    return f"{start}>{''.join(inside)}</{name}\n>" if inside else f"{start}\n/>"


DOCUMENTS = st.recursive(
    st.builds(element, NAMES, TEXTS, st.lists(MARKUP, max_size=3)),
    lambda below: st.builds(element, NAMES, TEXTS, st.lists(st.one_of(below, MARKUP), max_size=4)),
    max_leaves=8,
)


@given(DOCUMENTS)
def test_a_document_whose_comments_are_xml_means_the_same_after_blanking(text: str) -> None:
    assert etree.canonicalize(strict_xml(text.encode())) == etree.canonicalize(text)


@given(DOCUMENTS, st.sampled_from(COMMENTS))
def test_an_odd_comment_can_stand_anywhere_and_changes_nothing(text: str, comment: str) -> None:
    assert outline(parse(text.replace(PLACE, comment))) == outline(parse(text.replace(PLACE, "")))


@given(DOCUMENTS)
def test_blanking_keeps_every_line(text: str) -> None:
    strict = strict_xml(text.encode())
    assert strict.count("\n") == len(text.replace("\r\n", "\n").replace("\r", "\n").split("\n")) - 1
    found = parse(text)
    assert found.end_line >= max([found.line, *(child.end_line for child in found.children)])


def outline(element: Element) -> tuple[object, ...]:
    """Everything about an element."""
    children = [outline(child) for child in element.children]
    return element.tag, element.attributes, element.raw_text, element.line, element.end_line, children


def test_prefixes_stay_whether_they_are_declared_or_not() -> None:
    root = parse(
        "<x:a xmlns='d' xmlns:x='u' x:p='1' xml:lang='en'>"
        "<y:b y:q='2' z:r='3'/><c xmlns:y='v' y:s='4'/></x:a>"
    )
    assert (root.tag, root.attributes) == ("x:a", {"x:p": "1", "xml:lang": "en"})
    assert [(e.tag, e.attributes) for e in root.children] == [
        ("y:b", {"y:q": "2", "z:r": "3"}),
        ("c", {"y:s": "4"}),
    ]


@pytest.mark.parametrize("text", ["<a y:b='1' y:b='2'/>", "<y:a></y:b>", "<a><y:b/>" * 150])
def test_an_undeclared_prefix_forgives_nothing_else(text: str, golden: Golden) -> None:
    with golden.raises(SceneError):
        parse(text)


@pytest.mark.parametrize(
    ("text", "attributes"),
    [
        ("x='1'y='2'", {"x": "1", "y": "2"}),
        ("x=\"a'b\"y='>'", {"x": "a'b", "y": ">"}),
        ("x='a < b'\ny='2'", {"x": "a < b", "y": "2"}),
        ("x='&deg;'y='&lt;'", {"x": "&deg;", "y": "<"}),
    ],
)
def test_attributes_are_read_as_by_tinyxml(text: str, attributes: dict[str, str]) -> None:
    """The parser of MuJoCo and of Gazebo, whose words these are."""
    root = parse(f"<a>\n<b {text}/><!-- x='1'y='2' --><![CDATA[<c x='1'y='2'>]]>\n<d/></a>")
    assert root.children[0].attributes == attributes
    assert root.text == "<c x='1'y='2'>"
    assert root.children[1].line == 3 + text.count("\n")


def test_names_of_tags_with_two_colons_are_read_as_opensim_writes_them() -> None:
    root = parse('<a>\n<B::C name="x::y"><d>e::f</d></B::C></a>')
    assert [(each.tag, each.attributes, each.line) for each in root.children] == [
        ("B.C", {"name": "x::y"}, 2)
    ]
    assert root.children[0].require("d").text == "e::f"


@pytest.mark.parametrize("text", ["", "<a>", "<a></b>", "<a/><b/>", "<a b=1/>", "no xml"])
def test_xml_that_is_not_well_formed_is_refused_with_its_line(text: str, golden: Golden) -> None:
    with golden.raises(SceneError) as refusal:
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
def test_document_types_are_refused_before_an_entity_is_expanded(doctype: str, golden: Golden) -> None:
    with golden.raises(SceneError):
        parse(doctype)


@pytest.mark.parametrize("codec", ["utf-8", "utf-16", "utf-7", "gb18030"])
def test_document_types_are_refused_in_every_encoding(codec: str, golden: Golden) -> None:
    text = (
        f"<?xml version='1.0' encoding='{codec}'?>\n<!-- x --->\n<!DOCTYPE a\n [<!ENTITY x 'y'>]><a>&x;</a>"
    )
    with golden.raises(SceneError) as refusal:
        parse_xml(text.encode(codec), FILE)
    assert refusal.value.line == 3


def test_nothing_is_fetched(golden: Golden) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(0.2)
        address = f"http://127.0.0.1:{server.getsockname()[1]}/a"
        include = f"<i:include xmlns:i='http://www.w3.org/2001/XInclude' href='{address}'/>"
        schema = f"xmlns:s='http://www.w3.org/2001/XMLSchema-instance' s:schemaLocation='u {address}'"
        parse(f"<?xml-stylesheet href='{address}'?><a {schema}>{include}</a>")
        with golden.raises(SceneError):
            parse(f'<!DOCTYPE a SYSTEM "{address}"><a/>')
        with pytest.raises(TimeoutError):
            server.accept()


def test_nesting_has_a_limit(golden: Golden) -> None:
    assert parse("<a>" * 100 + "</a>" * 100).tag == "a"
    for depth in (101, 300, 5000):
        with golden.raises(SceneError, match="100"):
            parse("<a>\n" * depth + "</a>" * depth)


def test_texts_have_a_limit(golden: Golden) -> None:
    with golden.raises(SceneError, match=r"f\.sdf:2.*10"):
        parse_xml(b"<a>\n" + b"x" * 10_100_000 + b"</a>", Path("f.sdf"))


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
def test_anything_but_three_finite_numbers_is_refused_with_the_text_found(text: str) -> None:
    element = parse(f"<a>\n<v>{text}</v></a>").require("v")
    with pytest.raises(SceneError, match=text or "''") as refusal:
        element.numbers(3)
    assert str(refusal.value).startswith("robot.sdf:2: <v> must ")


@pytest.mark.parametrize("text", ["0", "-1", "0.0"])
def test_sizes_are_more_than_zero(text: str, golden: Golden) -> None:
    with golden.raises(SceneError):
        parse(f"<a><radius>{text}</radius></a>").positive("radius")


def test_a_size_without_a_default_must_be_there(golden: Golden) -> None:
    assert parse("<a/>").positive("radius", 2.0) == 2
    with golden.raises(SceneError):
        parse("<a/>").positive("radius")


@pytest.mark.parametrize(
    ("text", "value"), [("1", True), ("true", True), ("True", True), ("0", False), ("FALSE", False)]
)
def test_flags_are_words_or_digits(text: str, value: bool) -> None:
    assert parse(f"<a><static>{text}</static></a>").flag("static", not value) is value


def test_a_flag_that_is_neither_says_what_would_be_valid(golden: Golden) -> None:
    with golden.raises(SceneError, match="<static>.*'yes'.*0, 1"):
        parse("<a><static>yes</static></a>").flag("static", False)


def test_directions_have_length_one(golden: Golden) -> None:
    assert parse("<a><xyz>0 3 4</xyz></a>").direction("xyz", (0, 0, 1)) == (0, 0.6, 0.8)
    with golden.raises(SceneError):
        parse("<a><xyz>0 0 0</xyz></a>").direction("xyz", (0, 0, 1))


def test_an_attribute_that_is_needed_is_named(golden: Golden) -> None:
    assert parse("<a name=' x '/>").attribute("name") == "x"
    with golden.raises(SceneError, match=r'<a>.*name="\.\.\."'):
        parse("<a name=''/>").attribute("name")


def test_a_missing_file_is_named_with_one_that_is_there(tmp_path: Path, golden: Golden) -> None:
    (tmp_path / "husky.sdf").touch()
    with golden.raises(SceneError, match=r"huski\.sdf.*'husky\.sdf'"):
        read_xml(tmp_path / "huski.sdf")
    with golden.raises(SceneError):
        read_xml(tmp_path / "nowhere" / "husky.sdf")


def test_a_folder_is_refused_as_a_file(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(SceneError):
        read_xml(tmp_path)


def test_a_file_that_does_not_end_and_one_with_too_many_tags_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="is not a file of at most 50 MB"):
        read_xml(Path("/dev/zero"))
    (tmp_path / "large.sdf").write_text(f"<a>{'<b/>' * 10**6}</a>")
    with pytest.raises(SceneError, match="more than 1000000 tags"):
        read_xml(tmp_path / "large.sdf")
