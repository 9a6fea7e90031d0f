"""Documents with common faults, turned into XML that strict parsers accept; line numbers do not change.

Gazebo accepts more than XML allows: blanks before the declaration, any version in it, undeclared Latin-1, and
    ``--`` in comments. A recovering parser does not help: libxml2 then drops the text after ``<!-- x --->``.

Safe for files from anywhere: document types, and with them all entities, are refused before a parser runs.
"""

from __future__ import annotations

import re

VERBATIM = r"!\[CDATA\[.*?(?:\]\]>|\Z)|\?.*?(?:\?>|\Z)"
"""CDATA and processing instructions after their ``<``: the markup in them is not markup."""

_UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # the byte order marks
_DECLARED = re.compile(rb"\s*(<\?xml\s[^>]*?encoding\s*=\s*[\"']([^\"']+)[^>]*>)")
_DECLARATION = re.compile(r"\A\s*<\?xml\s.*?\?>", re.DOTALL)
_LINE_END = re.compile(r"\r\n?")
_SPECIAL = re.compile(rf"<(?:{VERBATIM}|!--(?P<comment>.*?)(?P<end>-->|\Z)|(?P<doctype>!DOCTYPE))", re.DOTALL)


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
    text = _LINE_END.sub("\n", _decoded(data))
    text = _DECLARATION.sub(lambda declaration: "\n" * declaration[0].count("\n"), text)

    def blanked(special: re.Match[str]) -> str:
        if special["doctype"]:
            line = text.count("\n", 0, special.start()) + 1
            raise XmlError("documents with a <!DOCTYPE> are refused: they can read other files", line)
        if not special["end"]:  # verbatim, or an unterminated comment, which the parser refuses
            return special[0]
        return "<!--" + "\n" * special["comment"].count("\n") + "-->"

    return _SPECIAL.sub(blanked, text)


def _decoded(data: bytes) -> str:
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
        raise XmlError(f"this is XML in an encoding that cannot be read: {error}", 1) from None
