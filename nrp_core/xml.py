"""XML as a tree with the file and line of every element, for messages that name them.

lxml parses. Lines are counted here: libxml2 keeps only 16 bits of a line number, and for an element it keeps
the line on which the start tag ends, while messages need the lines on which an element begins and ends.
"""

from __future__ import annotations

import re
import stat
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import hypot, isnan
from pathlib import Path
from typing import Any

from lxml import etree

from nrp_core.errors import ExperimentError, did_you_mean

VERBATIM = r"!\[CDATA\[.*?(?:\]\]>|\Z)|\?.*?(?:\?>|\Z)"
"""CDATA and processing instructions after their ``<``: the markup in them is not markup."""

_UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # the byte order marks
_DECLARED = re.compile(rb"(?>\s+|<!--.*?-->)*+(<\?xml\s[^>]*?encoding\s*=\s*[\"']([^\"']+)[^>]*>)", re.DOTALL)
_DECLARATION = re.compile(r"\A(?>\s+|<!--.*?-->)*+<\?xml\s.*?\?>", re.DOTALL)
_LINE_END = re.compile(r"\r\n?")
_SPECIAL = re.compile(
    rf"<(?:{VERBATIM}|!--(?P<comment>.*?)(?P<end>-->|\Z)|(?P<doctype>!DOCTYPE))|(?P<bare>&(?!(?:amp|lt|gt|quot|apos|#\d+|#x[\da-fA-F]+);))",
    re.DOTALL,
)


class XmlError(ValueError):
    """A document is refused at ``line``."""

    def __init__(self, message: str, line: int) -> None:
        super().__init__(message)
        self.line = line


def strict_xml(data: bytes) -> str:
    """Return the text of a document without its XML declaration.

    Each comment ends at the first ``-->`` and keeps only its line ends.

    Raises:
        XmlError: it has a document type, or its encoding cannot be read.
    """
    text = _LINE_END.sub("\n", _decode(data))
    text = _DECLARATION.sub(lambda declaration: "\n" * declaration[0].count("\n"), text)

    def blanked(special: re.Match[str]) -> str:
        if special["bare"]:
            return "&amp;"
        if special["doctype"]:
            line = text.count("\n", 0, special.start()) + 1
            raise XmlError("documents with a <!DOCTYPE> are refused: they can read other files", line)
        if not special["end"]:  # verbatim, or an unterminated comment, which the parser refuses
            return special[0]
        return "<!--" + "\n" * special["comment"].count("\n") + "-->"

    return _SPECIAL.sub(blanked, text)


def _decode(data: bytes) -> str:
    declared = _DECLARED.match(data)
    codec = declared[2].decode("latin-1").lower() if declared else "utf-8"
    if data[:2] in _UTF_16:
        codec, declared = "utf-16", None
    try:
        # Python also has codecs that are not text encodings, some very slow; they change the declaration.
        if declared and declared[1].decode(codec) != declared[1].decode("latin-1"):
            raise LookupError(f"{codec} differs from its declaration")
        return data.decode("utf-8-sig" if codec == "utf-8" else codec)
    except UnicodeDecodeError as error:
        if codec == "utf-8":
            return data.decode("latin-1")
        line = data.count(b"\n", 0, error.start) + 1
        raise XmlError(f"this XML is not in {codec}: {error.reason}", line) from None
    except (LookupError, ValueError) as error:
        raise XmlError(f"this is XML in the encoding {codec}, which cannot be read: {error}", 1) from None


_MAX_DEPTH = 100
_MOST_BYTES, _MOST_MARKS = 50_000_000, 1_000_000
_LARGEST = 1e30  # a mistake in any unit, and its powers overflow
_TRUTH = {"1": True, "true": True, "0": False, "false": False}
_XML_NAMESPACE = "http://www.w3.org/XML/1998/namespace"
_QUOTED = r"""(?:"[^"]*"|'[^']*')"""
_TAG = re.compile(
    rf"<(?:{VERBATIM}|!--.*?-->|(?P<end>/?)(?P<name>[^\s/>]+)[^\"'>]*(?:{_QUOTED}[^\"'>]*)*>)", re.DOTALL
)
_VALUE = re.compile(rf"({_QUOTED})([^\s/>]?)")
_LAST_END = re.compile(r"</[^<>]*>\s*\Z")
_PREFIX = re.compile(r"[<\s]([A-Za-z_][\w.-]*):", re.ASCII)
_DECLARED_PREFIX = re.compile(r"\sxmlns:([^\s=]+)")


class Attributes(dict[str, str]):
    """The attributes of an element.

    Args:
        given: their values by name.
        asked: the names that readers have looked for.
    """

    __slots__ = ("asked",)

    def __init__(self, given: Mapping[str, str], asked: set[str] | None = None) -> None:
        super().__init__(given)
        self.asked: set[str] = set() if asked is None else asked

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def get(self, name: str, default: Any = None) -> Any:
        self.asked.add(name)
        return super().get(name, default)


@dataclass(slots=True, eq=False)
class Element:
    """An XML element.

    Args:
        tag: its name, prefix included.
        attributes: its attributes.
        path, line: its beginning.
        children: its elements, in order.
        text: its own characters, stripped.
        raw_text: the same, unstripped.
        end_line: the line where it ends.
        kind: the class of errors about it.
        asked: the tags of children that readers have looked for, and whether for all of a tag.
        absent: empty elements in the place of missing ones that readers have looked into, by tag.
        passed_over: whether nothing in it is to be read.
    """

    tag: str
    attributes: dict[str, str]
    path: Path
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""
    raw_text: str = ""
    end_line: int = 0
    kind: type[ExperimentError] = ExperimentError
    asked: dict[str, bool] = field(default_factory=dict, repr=False)
    absent: dict[str, Element] = field(default_factory=dict, repr=False)
    passed_over: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.attributes, Attributes):
            self.attributes = Attributes(self.attributes)

    @property
    def where(self) -> str:
        """``file:line``."""
        return f"{self.path}:{self.line}"

    def error(self, message: str) -> ExperimentError:
        """Return an error that points here."""
        return self.kind(message, path=self.path, line=self.line)

    # -- structure

    def find(self, *tags: str) -> Element | None:
        """Return the first descendant along a path of tags, or None."""
        found: Element | None = self
        for tag in tags:
            if found is None:
                return None
            found.asked.setdefault(tag, False)
            found = next((child for child in found.children if child.tag == tag), None)
        return found

    def all(self, *tags: str) -> list[Element]:
        """Return the children with one of the tags, in the order of the file."""
        self.asked |= dict.fromkeys(tags, True)
        return [child for child in self.children if child.tag in tags]

    def require(self, tag: str) -> Element:
        """Return the first child with a tag; raise an error if it is missing."""
        found = self.find(tag)
        if found is None:
            raise self.error(f"<{self.tag}> needs a <{tag}>")
        return found

    def section(self, tag: str) -> Element:
        """Return the first child with a tag, or an empty element."""
        found = self.find(tag) or self.absent.get(tag)
        if found is None:
            found = self.absent[tag] = Element(tag, {}, self.path, self.line, kind=self.kind)
        return found

    @property
    def asked_attributes(self) -> set[str]:
        """The names of attributes that readers have looked for."""
        return self.attributes.asked if isinstance(self.attributes, Attributes) else set()

    def with_attributes(self, **values: str) -> Element:
        """Return a copy with other values of attributes; what is read of it counts as read of this one."""
        return replace(self, attributes=Attributes({**self.attributes, **values}, self.asked_attributes))

    def pass_over(self, *tags: str) -> None:
        """Mark the children with some tags as not needed, so that nothing in them is reported as unread."""
        for child in self.all(*tags):
            child.passed_over = True

    def attribute(self, name: str) -> str:
        """Return a required attribute, which must not be empty."""
        value = self.attributes.get(name, "").strip()
        if not value:
            raise self.error(f'<{self.tag}> needs an attribute {name}="..."')
        return value

    # -- values

    def numbers(self, count: int, *, finite: bool = True) -> tuple[float, ...]:
        """Return the element's text as ``count`` numbers."""
        return self.parse_numbers(self.text, count, finite=finite)

    def parse_numbers(self, text: str, count: int, *, finite: bool = True) -> tuple[float, ...]:
        """Return a text of this element as ``count`` numbers."""
        try:
            values = tuple(float(word) for word in text.split())
        except ValueError:
            values = ()
        if len(values) != count or any(map(isnan, values)):
            wanted = "a number" if count == 1 else f"{count} numbers"
            raise self.error(f"<{self.tag}> must hold {wanted}, not '{text}'")
        if finite and not all(abs(value) <= _LARGEST for value in values):
            raise self.error(f"<{self.tag}> must be finite and below {_LARGEST:g}, not '{text}'")
        return values

    def number(self, tag: str, default: float, *, finite: bool = True) -> float:
        """Return the number in a child."""
        child = self.find(tag)
        return default if child is None else child.numbers(1, finite=finite)[0]

    def positive(self, tag: str, default: float | None = None) -> float:
        """Return the number in a child, more than 0; without a default, the child is required."""
        child = self.find(tag)
        if child is None and default is not None:
            return default
        return self.require(tag).all_positive(1)[0]

    def direction(self, tag: str, default: tuple[float, float, float]) -> tuple[float, float, float]:
        """Return the unit vector along the three numbers in a child."""
        child = self.find(tag)
        x, y, z = default if child is None else child.numbers(3)
        length = hypot(x, y, z)
        if child is not None and not length:
            raise child.error(f"<{tag}> is 0 0 0, which has no direction")
        return x / length, y / length, z / length

    def all_positive(self, count: int) -> tuple[float, ...]:
        """Return the element's text as ``count`` numbers that are more than 0."""
        values = self.numbers(count)
        if not all(value > 0 for value in values):
            raise self.error(f"<{self.tag}> must be more than 0, not '{self.text}'")
        return values

    def word(self, tag: str, default: str = "") -> str:
        """Return the text of a child, or the default if it is missing or empty."""
        child = self.find(tag)
        return (child.text if child is not None else "") or default

    def choice(self, tag: str, words: Collection[str], default: str) -> str:
        """Return the text of a child, one of some words, or the default if it is missing or empty."""
        found = self.word(tag, default)
        if found not in words:
            message = f"<{tag}> must be one of {', '.join(words)}, not '{found}'"
            raise self.require(tag).error(f"{message}{did_you_mean(found, words)}")
        return found

    def flag(self, tag: str, default: bool) -> bool:
        """Return the truth value in a child."""
        child = self.find(tag)
        return default if child is None else child._truth(child.text, f"<{tag}>")

    def is_set(self, attribute: str) -> bool:
        """Return the truth value in an attribute, false if it is missing."""
        return self._truth(self.attributes.get(attribute, "false"), f"{attribute} of <{self.tag}>")

    def _truth(self, text: str, what: str) -> bool:
        if text.lower() not in _TRUTH:
            raise self.error(f"{what} is '{text}'{did_you_mean(text, _TRUTH)}")
        return _TRUTH[text.lower()]


def read_xml(path: Path, kind: type[ExperimentError]) -> Element:
    """Read a file.

    Raises:
        ExperimentError: of the given kind: it cannot be read, is not well-formed, or has a document type.
    """
    try:
        status = path.stat()
        is_endless = not (stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode))
        if is_endless or status.st_size > _MOST_BYTES:
            raise kind(f"{path} is not a file of at most {_MOST_BYTES // 10**6} MB")
        return parse_xml(path.read_bytes(), path, kind)
    except FileNotFoundError:
        if not path.parent.is_dir():
            raise kind(f"there is no file {path}; there is no folder {path.parent}") from None
        near = [other.name for other in path.parent.glob(f"*{path.suffix}")]
        hint = did_you_mean(path.name, near) if near else ""
        raise kind(f"there is no file {path}{hint}") from None
    except OSError as error:
        raise kind(f"cannot read {path}: {error.strerror}") from None


def parse_xml(data: bytes, path: Path, kind: type[ExperimentError]) -> Element:
    """Parse XML; ``path`` is for messages.

    Raises:
        ExperimentError: of the given kind: it is not well-formed, has a document type, or is too large.
    """
    try:
        text = strict_xml(data)
        if text.count("<") + text.count("=") > _MOST_MARKS:
            raise XmlError(f"this XML has more than {_MOST_MARKS} tags and attributes", 1)
        root = _parse(text)
    except XmlError as error:
        raise kind(str(error), path=path, line=error.line) from None
    return _elements(root.iter(), text, Element("", {}, path, 0, kind=kind))


def _parse(text: str) -> Any:
    """Return the root that lxml makes of a text."""
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        return etree.fromstring(text.encode(errors="surrogatepass"), parser)
    except etree.XMLSyntaxError:
        errors = [entry for entry in parser.error_log if entry.level >= etree.ErrorLevels.ERROR]
    others = [entry for entry in errors if entry.type != etree.ErrorTypes.NS_ERR_UNDEFINED_NAMESPACE]
    mended = _with_blanks(text) if others else _with_prefixes(text)
    if mended != text:
        return _parse(mended)
    first = (others or errors)[0]
    if first.type == etree.ErrorTypes.ERR_DOCUMENT_END and (needless := _LAST_END.search(text)):
        return _parse(text[: needless.start()])  # MuJoCo and Gazebo ignore end tags after the root
    if first.type == etree.ErrorTypes.ERR_RESOURCE_LIMIT:
        reason = (
            f"elements are nested more than {_MAX_DEPTH} deep, or a text is longer than 10 million characters"
        )
        raise XmlError(f"this XML is too large: {reason}", first.line)
    raise XmlError(f"this is not well-formed XML: {first.message.strip()}", first.line)


def _with_prefixes(text: str) -> str:
    """Return a document whose root declares the prefixes in its tags: Gazebo accepts undeclared ones."""
    tags = list(_tags(text))
    used = {prefix for tag in tags for prefix in _PREFIX.findall(tag[0])}
    used -= {"xml", "xmlns", *_DECLARED_PREFIX.findall(tags[0][0])}
    declarations = "".join(f' xmlns:{prefix}="{prefix}"' for prefix in sorted(used))
    start = tags[0].end("name")
    return text[:start] + declarations + text[start:]


def _with_blanks(text: str) -> str:
    """Return a document with blanks between attributes, ``<`` in none, and ``.`` for ``::`` in names of tags.

    MuJoCo and Gazebo read such attributes, and OpenSim writes such names.
    """

    def mended(value: re.Match[str]) -> str:
        return re.sub("<(?!!)", "&lt;", value[1]) + (" " if value[2] else "") + value[2]

    def mended_tag(tag: re.Match[str]) -> str:
        name = tag["name"] or ""
        return _VALUE.sub(mended, tag[0].replace(name, name.replace("::", "."), 1)) if name else tag[0]

    return _TAG.sub(mended_tag, text)


def _tags(text: str) -> Iterator[re.Match[str]]:
    """Yield the start and end tags of a well-formed document."""
    return (found for found in _TAG.finditer(text) if found["name"])


def _elements(nodes: Iterator[Any], text: str, document: Element) -> Element:
    """Return the parsed document as our tree, with the lines of its tags in document order."""
    above = [document]
    line, counted = 1, 0
    for tag in _tags(text):
        line += text.count("\n", counted, tag.start())
        counted = tag.start()
        if tag["end"]:
            above.pop().end_line = line
            if len(above) == 1:
                break
            continue
        element = _element(next(nodes), document.path, line, document.kind)
        if len(above) > _MAX_DEPTH:
            raise element.error(f"elements are nested more than {_MAX_DEPTH} deep")
        above[-1].children.append(element)
        if text[tag.end() - 2] == "/":
            element.end_line = line + tag[0].count("\n")
        else:
            above.append(element)
    return document.children[0]


def _element(node: Any, path: Path, line: int, kind: type[ExperimentError]) -> Element:
    tag, prefix = node.tag.rpartition("}")[2], node.prefix
    raw = "".join([node.text or "", *(child.tail or "" for child in node)])
    return Element(
        tag=f"{prefix}:{tag}" if prefix else tag,
        attributes={_as_written(name, node): value for name, value in node.items()},
        path=path,
        line=line,
        text=raw.strip(),
        raw_text=raw,
        kind=kind,
    )


def _as_written(attribute: str, node: Any) -> str:
    """Return the name of an attribute with its prefix instead of its namespace."""
    if attribute[0] != "{":
        return attribute
    space, _, name = attribute[1:].partition("}")
    prefixes = (prefix for prefix, uri in node.nsmap.items() if prefix and uri == space)
    return f"{'xml' if space == _XML_NAMESPACE else next(prefixes)}:{name}"
