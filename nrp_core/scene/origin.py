"""The sources of models, for engines that read files themselves or need more than a scene contains."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from nrp_core.errors import SceneError


@dataclass(frozen=True, slots=True)
class Native:
    """An element with a namespace, such as ``<mujoco:option cone="pyramidal"/>``, as in a file.

    In SDF, elements with a namespace are for the program that knows it; the core passes them to the engine.

    Args:
        namespace: ``mujoco``.
        tag: ``option``.
        attributes: names and values, in the order of the file.
        text: its text, stripped.
        children: the elements in it, with any namespace or an empty one.
        path, line: its beginning; None and 0 if it was made in Python.
    """

    namespace: str
    tag: str
    attributes: tuple[tuple[str, str], ...] = ()
    text: str = ""
    children: tuple[Native, ...] = ()
    path: Path | None = field(default=None, compare=False, repr=False)
    line: int = field(default=0, compare=False, repr=False)

    @property
    def full_tag(self) -> str:
        """Its tag as files have it: ``mujoco:option``."""
        return f"{self.namespace}:{self.tag}" if self.namespace else self.tag

    def attribute(self, name: str) -> str | None:
        """Return an attribute, or None."""
        return dict(self.attributes).get(name)

    def error(self, message: str) -> SceneError:
        """Return an error that points here."""
        return SceneError(f"<{self.full_tag}>: {message}", path=self.path, line=self.line or None)


@dataclass(frozen=True, slots=True)
class Source:
    """The element of a file that a model was read from.

    Args:
        file: the file, unpacked if it was in an archive.
        element: the name of its ``<model>`` or ``<robot>``.
        line: line of that element.
        without: lines of invalid elements that a lenient experiment omits.
    """

    file: Path
    element: str
    line: int
    without: tuple[int, ...] = ()
