"""The form of a layout: nested rows and columns of panels, and the curves of the plots."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Final, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from nrp_core.errors import did_you_mean
from nrp_core.experiment import Section

PANELS: Final = ("scene", "camera", "map", "brain", "spikes", "traces", "parameters", "inspector")
"""The kinds of panels of the page, as in ``page/src/state/panels.ts``."""


def _known(panel: str) -> str:
    kind, space, number = panel.partition(" ")
    if kind not in PANELS:
        raise ValueError(f"there is no panel '{panel}'{did_you_mean(kind, PANELS)}")
    if space and not (number.isdecimal() and int(number) > 1):
        raise ValueError(f"'{panel}': the panels of a kind are '{kind}', '{kind} 2', '{kind} 3' and so on")
    return panel


_Panel = Annotated[str, AfterValidator(_known)]


class Split(Section):
    """Panels in a row or a column, some of which are split again."""

    direction: Literal["row", "column"]
    """How the parts follow each other."""
    parts: tuple[
        Annotated[
            Annotated[_Panel, Tag("panel")] | Annotated[Split, Tag("split")],
            Discriminator(lambda part: "panel" if isinstance(part, str) else "split"),
        ],
        ...,
    ]
    """Panels by their kind, the second one as in ``camera 2``, and splits."""
    sizes: tuple[Annotated[float, Field(gt=0)], ...]
    """One for each part; only their ratios count."""

    @model_validator(mode="after")
    def _have_a_size_each(self) -> Self:
        if len(self.parts) != len(self.sizes):
            raise ValueError(f"it has {len(self.parts)} 'parts' and {len(self.sizes)} 'sizes'")
        return self

    def panels(self) -> Iterator[str]:
        """Yield the panels from left to right and from top to bottom."""
        for part in self.parts:
            if isinstance(part, str):
                yield part
            else:
                yield from part.panels()


class Curve(Section):
    """What a curve shows."""

    topic: str
    """The topic of its messages."""
    path: str
    """The field in a message, such as ``linear.x`` or ``position[0]``."""
    panel: _Panel = "traces"
    """The panel that it is in."""


class Arrangement(Section):
    """A layout of the page."""

    version: Literal[1]
    """The version of the form."""
    tree: Split
    """Where the panels are; each at most once."""
    traces: tuple[Curve, ...]
    """The curves of the plots."""
    choices: dict[_Panel, str] = Field(default_factory=dict)
    """What some panels show of several things, such as the topic of a camera."""

    @model_validator(mode="after")
    def _holds_panels_once(self) -> Self:
        panels = list(self.tree.panels())
        if not panels:
            raise ValueError("tree: there is no panel in it")
        for panel in panels:
            if panels.count(panel) > 1:
                raise ValueError(f"tree: the panel '{panel}' is twice in it")
        return self
