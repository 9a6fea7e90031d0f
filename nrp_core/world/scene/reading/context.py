"""What one reading of a file carries along: where to look for other files, and what there is to warn of."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from nrp_core.world.scene.reading.left_out import Places
from nrp_core.world.scene.reading.resources import Resources
from nrp_core.world.scene.reading.xml import Element


class Notes:
    """The warnings of one reading; what is said of many elements is said once, with the first place."""

    def __init__(self) -> None:
        self._places: dict[str, list[str]] = {}

    def warn(self, element: Element, message: str) -> None:
        """Warn of an element."""
        self._places.setdefault(message, []).append(element.where)

    @property
    def texts(self) -> tuple[str, ...]:
        """Every warning as ``file:line: message``."""
        return tuple(
            f"{places[0]}: {message}" + (f" (and {len(places) - 1} more)" if places[1:] else "")
            for message, places in self._places.items()
        )


@dataclass(frozen=True, slots=True)
class Reading:
    """Passed to everything that reads a part of a model.

    Args:
        resources: finds meshes and included files.
        notes: takes warnings.
        robot: name of the whole model; relative topics in its file resolve below it.
        scope: what comes before the names of parts of a model nested in it, ``arm::``.
        without: what is left out of files.
        lenient: whether an included file that is not there is left out, with a warning, instead of refused.
    """

    resources: Resources
    notes: Notes
    robot: str = ""
    scope: str = ""
    without: Places = field(default_factory=dict)
    lenient: bool = False

    def within(self, prefix: str) -> Reading:
        """Return the reading of a nested model."""
        return replace(self, scope=self.scope + prefix)

    def topic_of(self, part: str, name: str) -> str:
        """Return the topic that a part of the model (a link, a joint) has by default."""
        return f"{self.scope}{part}/{name}".replace("::", "/")
