"""XML as a tree that knows the file and line of every element, for messages that name them.

Safe for files from anywhere: document types, and with them entities of any kind, are refused.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from math import hypot, isnan
from pathlib import Path
from xml.parsers import expat

from nrp_core.errors import ExperimentError, did_you_mean

_MAX_DEPTH = 100
_LARGEST = 1e30  # in any unit it is a slip, and its powers are not finite any more
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # how such documents begin
_TRUTH = {"1": True, "true": True, "0": False, "false": False}


@dataclass(slots=True, eq=False)
class Element:
    """An XML element.

    Args:
        tag: its name, prefix included.
        attributes: its attributes.
        path, line: where it begins.
        children: its elements, in order.
        text: its own characters, stripped.
        raw_text: the same as they stand in the file.
        end_line: where it ends.
        kind: the class of errors about it.
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
            found = next((child for child in found.children if child.tag == tag), None) if found else None
        return found

    def all(self, *tags: str) -> list[Element]:
        """Return the children with one of the tags, in the order of the file."""
        return [child for child in self.children if child.tag in tags]

    def require(self, tag: str) -> Element:
        """Return the first child with a tag; it is an error if there is none."""
        found = self.find(tag)
        if found is None:
            raise self.error(f"<{self.tag}> needs a <{tag}>")
        return found

    def section(self, tag: str) -> Element:
        """Return the first child with a tag; where there is none, an empty one in its place."""
        return self.find(tag) or Element(tag, {}, self.path, self.line, kind=self.kind)

    def attribute(self, name: str) -> str:
        """Return an attribute that must be there and not empty."""
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
        """Return the number in a child, more than 0; where there is no default, the child must be there."""
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
        """Return the text of a child, or the default where there is none or it is empty."""
        child = self.find(tag)
        return (child.text if child is not None else "") or default

    def flag(self, tag: str, default: bool) -> bool:
        """Return the truth value in a child."""
        child = self.find(tag)
        return default if child is None else child._truth(child.text, f"<{tag}>")

    def is_set(self, attribute: str) -> bool:
        """Return the truth value in an attribute, false where there is none."""
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
        return parse_xml(path.read_bytes(), path, kind)
    except FileNotFoundError:
        if not path.parent.is_dir():
            raise kind(f"there is no file {path}; there is no folder {path.parent}") from None
        near = [other.name for other in path.parent.glob(f"*{path.suffix}")]
        hint = did_you_mean(path.name, near) if near else ""
        raise kind(f"there is no file {path}{hint}") from None
    except OSError as error:
        raise kind(f"cannot read {path}: {error.strerror}") from None


def parse_xml(text: bytes, path: Path, kind: type[ExperimentError]) -> Element:
    """Parse XML; ``path`` is for messages.

    Raises:
        ExperimentError: of the given kind: it is not well-formed, or has a document type.
    """
    builder = _Builder(path, kind)
    try:
        builder.parser.Parse(_forgiven(text), True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise kind(f"this is not well-formed XML: {reason}", path=path, line=error.lineno) from None
    except (LookupError, ValueError) as error:  # of the codec that the document names
        if isinstance(error, ExperimentError):
            raise
        raise kind(f"this is XML in an encoding that cannot be read: {error}", path=path, line=1) from None
    return builder.root.children[0]


def _forgiven(text: bytes) -> bytes:
    """Return a document without what most parsers forgive and expat does not; its lines stay.

    Blanks before the declaration, and Latin-1 that is not declared.
    """
    declaration = re.match(rb"(\s*)(<\?xml\b.*?\?>)", text, re.DOTALL)
    if declaration:
        text = declaration[2] + declaration[1] + text[declaration.end() :]
    encoding = re.search(rb"encoding\s*=\s*[\"']([^\"']*)", declaration[2]) if declaration else None
    if text[:2] not in _UTF_16 and (not encoding or encoding[1].lower() == b"utf-8"):
        try:
            text.decode()
        except UnicodeDecodeError:
            return text.decode("latin-1").encode()
    return text


class _Builder:
    def __init__(self, path: Path, kind: type[ExperimentError]) -> None:
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._characters
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.root = Element("", {}, path, 0, kind=kind)
        self._open = [self.root]

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = self._here(tag, attributes)
        if len(self._open) > _MAX_DEPTH:
            raise element.error(f"elements are nested more than {_MAX_DEPTH} deep")
        self._open[-1].children.append(element)
        self._open.append(element)

    def _end(self, tag: str) -> None:
        closed = self._open.pop()
        closed.text = closed.raw_text.strip()
        closed.end_line = self.parser.CurrentLineNumber

    def _characters(self, text: str) -> None:
        self._open[-1].raw_text += text

    def _doctype(self, *declaration: object) -> None:
        raise self._here("", {}).error("documents with a <!DOCTYPE> are refused: they can read other files")

    def _here(self, tag: str, attributes: dict[str, str]) -> Element:
        root = self.root
        return Element(tag, attributes, root.path, self.parser.CurrentLineNumber, kind=root.kind)
