"""References in docstrings, as the site shows them: ``:class:`Pose``` becomes code."""

from __future__ import annotations

import re
from typing import Any

import griffe

_ROLE = re.compile(r":(?:class|func|meth|mod|data|attr|exc):`~?([^`]+)`")
_CODE = re.compile(r"``([^`\n]+)``")
_LITERAL = re.compile(r"(?<=(\S))?::(?=\n\n +\S)")


def to_markdown(text: str) -> str:
    """Return a docstring with its few marks of reStructuredText as those of Markdown."""
    text = _ROLE.sub(lambda match: f"`{match[1].rpartition('.')[2]}`", text)
    return _LITERAL.sub(lambda match: ":" if match[1] else "", _CODE.sub(r"`\1`", text))


class Roles(griffe.Extension):
    """Shows docstrings as Markdown."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        """Change the docstring of an object."""
        if obj.docstring:
            obj.docstring.value = to_markdown(obj.docstring.value)
