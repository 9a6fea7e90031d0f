"""The context of reading a file: where to look for other files, and the warnings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from nrp_core.findings import Code, Finding, Level, merged
from nrp_core.world.scene.reading.left_out import Places
from nrp_core.world.scene.reading.resources import Resources
from nrp_core.world.scene.reading.xml import Element


class Notes:
    """The warnings of one reading; a warning about many elements is given once, with the first place."""

    def __init__(self) -> None:
        self._findings: list[Finding] = []

    def warn(self, element: Element, code: Code, message: str, *, subject: str | None = None) -> None:
        """Warn of an element."""
        where = element.path, element.line
        self._findings.append(Finding(code, message, Level.WARNING, *where, subject=subject))

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All warnings; a warning about many elements is listed once, with the first place."""
        return merged(self._findings)


@dataclass(frozen=True, slots=True)
class Reading:
    """The context of reading a model, passed to all readers of its parts.

    Args:
        resources: the search for meshes and included files.
        notes: collects warnings.
        robot: name of the whole model; relative topics in its file resolve below it.
        scope: the prefix of the names of parts of a nested model, ``arm::``.
        without: the elements to leave out of files.
        args: arguments of a xacro file.
        lenient: whether a missing included file is left out with a warning instead of an error.
    """

    resources: Resources
    notes: Notes
    robot: str = ""
    scope: str = ""
    without: Places = field(default_factory=dict)
    args: Mapping[str, object] = field(default_factory=dict)
    lenient: bool = False

    def within(self, prefix: str) -> Reading:
        """Return the reading of a nested model."""
        return replace(self, scope=self.scope + prefix)

    def topic_of(self, part: str, name: str) -> str:
        """Return the default topic of a part of the model (a link, a joint)."""
        return f"{self.scope}{part}/{name}".replace("::", "/")
