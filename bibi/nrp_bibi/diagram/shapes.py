"""The shapes of a diagram: cards with text and arrows between them, in pixels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

TITLE, LINE, PADDING, GAP = 22, 16, 9, 14
"""The heights of a title and of a line of text, the margin around text, and the gap between cards."""
INDENT = 12
"""From the left edge of a card to its text."""
_MONOSPACED, _PROPORTIONAL, _BOLD = 7.23, 6.7, 7.7
"""The widths of characters: of DejaVu Sans Mono at 12 px, the widest such font, and on average of others."""


@dataclass(frozen=True, slots=True)
class Card:
    """A box with a title and lines of text.

    Args:
        style: its class in the style sheet.
        title: the title, shown in bold.
        lines: the lines below the title.
        x, width: the left edge and the width.
        y: the top edge.
    """

    style: str
    title: str
    lines: Sequence[str]
    x: int
    width: int
    y: float = 0

    @property
    def height(self) -> int:
        """The height that the text needs."""
        return TITLE + LINE * len(self.lines) + 2 * PADDING - 4

    @property
    def middle(self) -> float:
        """The vertical centre."""
        return self.y + self.height / 2

    @property
    def texts(self) -> Iterator[tuple[float, str]]:
        """The lines, each with the y coordinate of its baseline."""
        top = self.y + PADDING + TITLE
        character = _MONOSPACED if self.style == "function" else _PROPORTIONAL
        return ((top + LINE * i + 8, self._fitted(text, character)) for i, text in enumerate(self.lines))

    @property
    def heading(self) -> str:
        """The title, as much of it as fits."""
        return self._fitted(self.title, _BOLD)

    def _fitted(self, text: str, character: float) -> str:
        """Return a text, shortened to fit; ``character`` is the width of one character."""
        most = int((self.width - 2 * INDENT) / character)
        return text if len(text) <= most else f"{text[: most - 3]}..."


@dataclass(frozen=True, slots=True)
class Arrow:
    """A curve from one card to another beside it.

    Args:
        start, end: the two ends.
        is_plain: whether it is drawn without an arrow head.
    """

    start: tuple[float, float]
    end: tuple[float, float]
    is_plain: bool = False

    @property
    def path(self) -> str:
        """Its path in SVG."""
        (x, y), (to_x, to_y) = self.start, self.end
        between = (x + to_x) / 2
        return f"M{x:g},{y:g} C{between:g},{y:g} {between:g},{to_y:g} {to_x:g},{to_y:g}"


@dataclass(slots=True)
class Drawing:
    """Cards and arrows."""

    cards: list[Card] = field(default_factory=list)
    arrows: list[Arrow] = field(default_factory=list)


def stacked(cards: Sequence[Card], top: float, height: float) -> list[Card]:
    """Return cards below each other, centred vertically in a height."""
    y = top + (height - height_of(cards)) / 2
    placed = []
    for card in cards:
        placed.append(replace(card, y=y))
        y += card.height + GAP
    return placed


def height_of(cards: Sequence[Card]) -> int:
    """Return the height of cards stacked below each other."""
    return sum(card.height for card in cards) + GAP * max(len(cards) - 1, 0)
