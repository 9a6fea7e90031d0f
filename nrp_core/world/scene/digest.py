"""Digests of scenes from declared tags and values: renamed classes and moved files do not change them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path

LATER: Mapping[str, object] = {"later": True}
"""Metadata of a field that was added later: at its default it is left out, so that earlier digests hold."""


def digest_of(value: object) -> str:
    """Return the digest of data; fields that are excluded from comparisons are excluded here."""
    return hashlib.blake2b(_text(value).encode(), digest_size=16).hexdigest()


def _text(value: object) -> str:
    """Return data as text: fields by name, after the ``tag`` of their class if it has one."""
    if is_dataclass(value) and not isinstance(value, type):
        entries = {
            field.name: getattr(value, field.name)
            for field in fields(value)
            if field.compare
            and not ("later" in field.metadata and getattr(value, field.name) == field.default)
        }
        return getattr(value, "tag", "") + _text(entries)
    if isinstance(value, Mapping):
        return "{" + ",".join(f"{key}:{_text(value[key])}" for key in sorted(value)) + "}"
    if isinstance(value, tuple | list):
        return "[" + ",".join(map(_text, value)) + "]"
    if isinstance(value, Path):
        return repr(value.name)  # meshes are named by a digest of their contents
    if value is None or isinstance(value, bool | int | float | str):
        return repr(value)
    raise TypeError(f"a scene holds a {type(value).__name__}, which has no digest: {value!r:.60}")
