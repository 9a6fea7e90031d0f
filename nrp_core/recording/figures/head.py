"""The head of the page: the experiment, its backends, and the outcomes of its criteria."""

from __future__ import annotations

from textwrap import shorten
from typing import Any

from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.offsetbox import AnchoredOffsetbox, HPacker, TextArea, VPacker

from nrp_core.experiment.running.judgement import Judgement, recorded_judgement
from nrp_core.recording.figures.story import Story
from nrp_core.recording.figures.style import BAD, FAINT, GOOD, points

HEAD_TOP_IN = 0.28
_CHARACTERS_AN_IN = 15
_A_LINE_IN = 3.1
"""Width of the page for each criterion in a line."""


def draw_head(figure: Figure, story: Story, side: float) -> None:
    """Write the head; a share of the width stays free on both sides."""
    run = story.run
    name = str(run.get("experiment", "recording"))
    top = 1 - HEAD_TOP_IN / figure.get_figheight()
    figure.text(side, top, name, fontsize=points(15), weight="bold", va="top")
    sides = [str(dict(run.get(side) or {}).get("backend", "")) for side in ("brain", "world")]
    shown = f"{story.begin_s:g} to {story.end_s:g} s" if story.begin_s else f"{story.end_s:g} s"
    facts = [" \N{MULTIPLICATION SIGN} ".join(filter(None, sides)), shown]
    if "seed" in run:
        facts.append(f"seed {run['seed']}")
    below = top - points(24) / 72 / figure.get_figheight()
    text = "   ·   ".join(filter(None, facts))
    figure.text(side, below, text, color=FAINT, fontsize=points(9.5), va="top")
    judgement = recorded_judgement(run, story.end_s)
    if judgement is not None:
        _draw_problems(figure, (side, below - points(15) / 72 / figure.get_figheight()), judgement)
    _draw_verdict(figure, (1 - side, top), dict((run.get("result") or {}).get("criteria") or {}))


def _draw_problems(figure: Figure, corner: tuple[float, float], judgement: Judgement) -> None:
    """Write the judgement of a run that is not complete or ended early, and its weightiest problems."""
    groups = [group.headline for group in judgement.groups]
    if judgement.complete and judgement.covers_all:
        text, color = f"problems: {'; '.join(groups)}" if groups else "", FAINT
    else:
        text, color = "; ".join([judgement.headline, *groups]), FAINT if judgement.complete else BAD
    text = shorten(text, round(_CHARACTERS_AN_IN * figure.get_figwidth()), placeholder=" …")
    figure.text(*corner, text, color=color, fontsize=points(8.5), va="top")


def _draw_verdict(figure: Figure, corner: tuple[float, float], criteria: dict[str, Any]) -> None:
    """Write the criteria with their marks in the upper right corner, as many in a line as fit."""
    count = max(1, round(figure.get_figwidth() / _A_LINE_IN))
    words: list[Artist] = [_criterion(name, outcome) for name, outcome in criteria.items()]
    lines: list[Artist] = [
        HPacker(children=words[i : i + count], sep=14, pad=0) for i in range(0, len(words), count)
    ]
    if lines:
        box = VPacker(children=lines, align="right", sep=5, pad=0)
        figure.add_artist(
            AnchoredOffsetbox(
                "upper right", child=box, frameon=False, pad=0, borderpad=0,
                bbox_to_anchor=corner, bbox_transform=figure.transFigure,
            )
        )  # fmt: skip


def _criterion(name: str, outcome: Any) -> TextArea:
    marks = {True: ("✓", GOOD), False: ("✗", BAD), None: ("?", FAINT)}
    mark, color = marks[outcome["passed"]]
    return TextArea(f"{mark} {name}", textprops={"color": color, "fontsize": points(9.5), "weight": "bold"})
