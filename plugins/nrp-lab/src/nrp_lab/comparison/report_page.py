"""A comparison as one self-contained HTML page."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

import jinja2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from nrp_core.brain import FloatArray
from nrp_core.recording.figures.style import BAD, FAINT, GOOD, INK, colour, style
from nrp_lab.comparison import report, timesteps
from nrp_lab.comparison.divergence import common_signals
from nrp_lab.comparison.evidence import Evidence, about
from nrp_lab.comparison.grid import Condition, GridCell, RunGrid
from nrp_lab.comparison.judgement import Answer, Contrast, Factor, JudgedPart, Judgement, Relation
from nrp_lab.comparison.old_records import RecordsDiff
from nrp_lab.comparison.result import GridDiff, PairDiff
from nrp_lab.comparison.signals import RunSignals

_WIDE = 11.0
_MARKERS = "osD^vP*X"
_COLUMNS = 3
_MAX_STRIPS = 9
_MAX_PARTS = 4
_MAX_ROWS = 60
_LONGEST = 38
_COLOURS = {Relation.EQUIVALENT: GOOD, Relation.OPEN: "#b9770e", Relation.DIFFERENT: BAD}
_SHAPES = {Factor.BRAIN: "o", Factor.WORLD: "s", Factor.WIRING: "D", Factor.TIMESTEP: "v"}
_STILL_M = 1e-6
_BEYOND = 30.0
"""Effects are drawn up to this many margins, on a scale that is linear up to 2."""


def svg(figure: Figure) -> str:
    """Return a figure as an SVG element."""
    text = io.StringIO()
    # cropped, because axes of equal scale may be flat
    figure.savefig(text, format="svg", metadata={"Date": None}, bbox_inches="tight", pad_inches=0.05)
    found = re.search(r"<svg.*</svg>", text.getvalue(), re.DOTALL)
    assert found is not None
    return re.sub(r'width="[^"]*pt" height="[^"]*pt" ', "", found[0], count=1)


def grid_figures(diff: GridDiff) -> Iterator[tuple[str, str, str]]:
    """Return the title, the caption and the SVG of every figure that the runs allow."""
    with style():
        for title, caption, figure in (
            ("Results", _ABOUT_STRIPS, strips(diff)),
            (f"Differences between {_compared(diff.grid)}", _ABOUT_FOREST, forest(diff.judgements)),
            ("Where the robots went", _ABOUT_TRAJECTORIES, trajectories(diff)),
            ("How runs diverge", _ABOUT_APART, apart(diff)),
        ):
            if figure is not None:
                yield title, caption, svg(figure)


_ABOUT_STRIPS = (
    "Every mark is a run, every line the mean of a row; the grey bar is the margin about the "
    "mean of all. First the metrics of the finding, then those that depend on what is compared."
)
_ABOUT_FOREST = (
    "The largest difference in each part of the finding, and in the parts of each other metric that differ "
    "most, in margins, with its 90 % interval. Dots: brains; squares: worlds; diamonds: wirings; triangles: "
    "time steps. "
    "Differences inside the band do not matter; green: shown to be inside, red: outside, yellow: undecided."
)
_ABOUT_TRAJECTORIES = "From above, a line for every seed. Dots: the ends."
_ABOUT_APART = (
    "How far the robots of two runs are from each other at one time, the median over pairs of runs. Grey: "
    "two seeds under equal conditions, from the 10th to the 90th percentile; a line within the grey is a "
    "difference that another seed makes too. A run that ended early stays where it ended."
)


# -- values


def strips(diff: GridDiff) -> Figure | None:
    """Draw the values of the finding, and of the metrics that depend on the compared variants."""
    finding = [one for one in diff.finding if one.metric.is_finding]
    wanted = [(one, part) for one in finding for part in one.parts if part.cells and _varied(part)]
    for judged in diff.judgements:
        if judged not in finding:
            dependent = [part for part in judged.parts if part.cells and part.answer.is_dependent]
            wanted += [(judged, part) for part in _most_telling(dependent, 2)]
    if not wanted:
        return None
    wanted = wanted[:_MAX_STRIPS]
    rows = -(-len(wanted) // _COLUMNS)
    height = 0.5 + rows * (0.65 + 0.24 * len(diff.grid.conditions))
    figure = Figure(figsize=(_WIDE, height), layout="constrained")
    axes = figure.subplots(rows, _COLUMNS, squeeze=False)
    for at, (judged, part) in zip(axes.flat, wanted, strict=False):
        _strip(at, diff.grid, judged, part)
    for at in axes.flat[len(wanted) :]:
        at.set_axis_off()
    for row in axes[:, 1:]:
        for at in row:
            at.set_yticklabels([])
    return figure


def _most_telling(parts: Sequence[JudgedPart], most: int) -> list[JudgedPart]:
    """Return the parts with the largest differences, in margins, in their own order."""
    found = sorted(parts, key=lambda part: -_size(part))[:most]
    return [part for part in parts if part in found]


def _size(part: JudgedPart) -> float:
    largest = part.largest
    return 0.0 if largest is None else abs(largest.estimate.mean) / (part.margin or 1.0)


def _varied(part: JudgedPart) -> bool:
    return len({value for cell in part.cells for value in cell.values}) > 1


def _strip(axes: Axes, grid: RunGrid, judged: Judgement, part: JudgedPart) -> None:
    metric, everything = judged.metric, [value for cell in part.cells for value in cell.values]
    middle = float(np.mean(everything)) if everything else 0.0
    axes.axvspan(middle - part.margin, middle + part.margin, color="#ececec", linewidth=0)
    for row, cell in enumerate(part.cells):
        shade = colour(_number(grid, cell.brain, cell.wiring))
        marker = _MARKERS[grid.worlds.index(cell.world) % len(_MARKERS)]
        spread = np.linspace(-0.22, 0.22, max(len(cell.values), 1))
        axes.plot(
            cell.values, row + spread[: len(cell.values)], marker, color=shade, markersize=3.5, alpha=0.65,
            markeredgewidth=0,
        )  # fmt: skip
        if cell.values:
            axes.plot([np.mean(cell.values)] * 2, [row - 0.38, row + 0.38], color=shade, linewidth=1.8)
    names = [grid.label(Condition(cell.brain, cell.world, cell.wiring)) for cell in part.cells]
    axes.set_yticks(range(len(part.cells)), names)
    axes.set_ylim(len(part.cells) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.set_title(f"{metric.title}\n{_short(part.name)}")
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.set_xlabel(f"{metric.unit or metric.title.lower()}   ({part.answer})", color=_shade_of(part.answer))


def _compared(grid: RunGrid) -> str:
    if grid.timesteps:
        return "time steps"
    return "wirings" if grid.compares_wirings else "backends"


def _number(grid: RunGrid, brain: str, wiring: str) -> int:
    """Return the number of the colour of a brain; of a wiring where wirings are compared."""
    return grid.variants.index(wiring) if grid.compares_variants else grid.brains.index(brain)


def _short(name: str) -> str:
    """Return a name, shortened to its end if it is long."""
    return name if len(name) <= _LONGEST else f"…{name[1 - _LONGEST :]}"


def _shade_of(answer: Answer) -> str:
    return GOOD if answer.is_independent else BAD if answer.is_dependent else INK


# -- effects


def forest(judgements: Sequence[Judgement]) -> Figure | None:
    """Draw the effect of each backend or wiring on each part, in margins."""
    rows = [
        (_short(f"{judged.metric.title}: {part.name}"), part, one)
        for judged in judgements
        for part in (judged.parts if judged.metric.is_finding else _most_telling(judged.parts, _MAX_PARTS))
        for one in _shown(part)
    ][:_MAX_ROWS]
    if not rows:
        return None
    figure = Figure(figsize=(_WIDE, 0.9 + 0.21 * len(rows)), layout="constrained")
    axes = figure.add_subplot()
    axes.axvspan(-1, 1, color="#e4efe9", linewidth=0)
    axes.axvline(0, color=FAINT, linewidth=0.6)
    for number, (_, part, one) in enumerate(rows):
        _effect(axes, number, part, one)
    labels = [f"{label}  ({one.factor})" for label, _, one in rows]
    axes.set_yticks(range(len(rows)), labels)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xscale("symlog", linthresh=2, linscale=1.5)
    axes.set_xlim(-_BEYOND, _BEYOND)
    ticks = [-30, -10, -3, -1, 0, 1, 3, 10, 30]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks], minor=False)
    axes.set_xticks([], minor=True)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="x")
    axes.set_xlabel("difference in margins")
    return figure


def _shown(part: JudgedPart) -> list[Contrast]:
    """Return the largest contrast of each factor."""
    found = []
    for factor in _SHAPES:
        own = [one for one in part.contrasts if one.factor is factor]
        if own and part.margin:
            found.append(max(own, key=lambda one: abs(one.estimate.mean)))
    return found


def _effect(axes: Axes, row: int, part: JudgedPart, one: Contrast) -> None:
    shade = _COLOURS[one.relation(part.margin)]
    low, high = (np.clip(end / part.margin, -_BEYOND, _BEYOND) for end in one.estimate.interval)
    middle = np.clip(one.estimate.mean / part.margin, -_BEYOND, _BEYOND)
    axes.plot([low, high], [row, row], color=shade, linewidth=1.6, solid_capstyle="butt")
    axes.plot([middle], [row], _SHAPES[one.factor], color=shade, markersize=4.5)


# -- trajectories


def trajectories(diff: GridDiff) -> Figure | None:
    """Draw the trajectories from above, a panel for each condition."""
    grid, conditions = diff.grid, diff.grid.conditions
    columns = min(len(conditions), 4)
    rows = -(-len(conditions) // columns)
    figure = Figure(figsize=(_WIDE, 3.6 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    drawn = False
    for axes, condition in zip(panels.flat, conditions, strict=False):
        axes.set(title=grid.label(condition), xlabel="x (m)", ylabel="y (m)")
        axes.set_aspect("equal", adjustable="box")
        axes.xaxis.set_major_locator(MaxNLocator(3))
        axes.label_outer()
        for seed in grid.seeds:
            number = _number(grid, condition.brain, condition.wiring)
            drawn |= _draw_ways(axes, diff.runs[condition.cell(seed)], number)
    for axes in panels.flat[len(conditions) :]:
        axes.set_axis_off()
    return figure if drawn else None


def _moves(run: RunSignals, robot: str) -> bool:
    return bool(np.ptp(run.motion(robot).values[:, :2], axis=0).max() > _STILL_M)


def _draw_ways(axes: Axes, run: RunSignals, number: int) -> bool:
    for robot in run.robots:
        x, y = run.motion(robot).values[:, :2].T
        axes.plot(x, y, color=colour(number), linewidth=0.7, alpha=0.55)
        axes.plot(x[-1:], y[-1:], "o", color=INK, markersize=2.2, zorder=3)
    return any(_moves(run, robot) for robot in run.robots)


# -- divergence over time


def apart(diff: GridDiff) -> Figure | None:
    """Draw the distance of runs over time: of other seeds, brains, worlds, wirings."""
    grid, runs = diff.grid, diff.runs
    robots = [
        robot
        for robot in next(iter(runs.values())).robots
        if any(_moves(run, robot) for run in runs.values())
    ]
    if not robots or len(diff.runs) < 2:
        return None
    figure = Figure(figsize=(_WIDE, 0.5 + 2.6 * len(robots)), layout="constrained")
    for number, robot in enumerate(robots, 1):
        axes = figure.add_subplot(len(robots), 1, number)
        times_s, places = _places(runs, robot)
        seeds = [
            _gap(places, condition.cell(one), condition.cell(other))
            for condition in grid.conditions
            for one, other in combinations(grid.seeds, 2)
        ]
        if seeds:
            low, high = np.percentile(seeds, [10, 90], axis=0)
            axes.fill_between(times_s, low, high, color="#dddddd", linewidth=0)
            axes.plot(times_s, np.median(seeds, axis=0), color=FAINT, linewidth=1)
        handles = [Line2D([], [], color=FAINT, label="another seed")]
        for shade, (label, gaps) in enumerate(_gaps(grid, places)):
            axes.plot(times_s, np.median(gaps, axis=0), color=colour(shade), linewidth=1.2)
            handles.append(Line2D([], [], color=colour(shade), label=label))
        axes.set(ylabel=f"{robot}: apart (m)", xlim=(0, times_s[-1]), ylim=(0, None))
        axes.legend(handles=handles, loc="upper left", ncols=4)
    axes.set_xlabel("simulated time (s)")
    return figure


def _places(runs: Mapping[GridCell, RunSignals], robot: str) -> tuple[FloatArray, dict[GridCell, FloatArray]]:
    """Return the position of a robot in every run at a few hundred common times."""
    times_s = max((run.times_s for run in runs.values()), key=len)
    times_s = times_s[:: max(1, len(times_s) // 400)]
    return times_s, {cell: run.held(run.motion(robot), times_s)[:, :2] for cell, run in runs.items()}


def _gap(places: Mapping[GridCell, FloatArray], one: GridCell, other: GridCell) -> FloatArray:
    gap: FloatArray = np.linalg.norm(places[one] - places[other], axis=1)
    return gap


def _gaps(grid: RunGrid, places: Mapping[GridCell, FloatArray]) -> Iterator[tuple[str, list[FloatArray]]]:
    """Return the gaps between runs of one seed on two backends, or with two wirings."""
    for a, b in combinations(grid.brains, 2):
        pairs = [(GridCell(a, w, s), GridCell(b, w, s)) for w in grid.worlds for s in grid.seeds]
        yield f"{a} / {b}", [_gap(places, *pair) for pair in pairs]
    for a, b in combinations(grid.worlds, 2):
        pairs = [(GridCell(x, a, s), GridCell(x, b, s)) for x in grid.brains for s in grid.seeds]
        yield f"{a} / {b}", [_gap(places, *pair) for pair in pairs]
    original, *controls = grid.conditions if grid.compares_variants else grid.conditions[:1]
    for control in controls:
        yield control.wiring, [_gap(places, original.cell(s), control.cell(s)) for s in grid.seeds]


# -- two recordings


def pair_figures(diff: PairDiff) -> Iterator[tuple[str, str, str]]:
    """Return the figures of two recordings."""
    with style():
        robots = [robot for robot in diff.one.robots if robot in diff.other.robots]
        if robots:
            caption = "From above; blue the first recording, red the second."
            yield "Where the robots went", caption, svg(_both_ways(diff, robots))
        chosen = [one for one in diff.deviations if one.span and one.largest][:6]
        if chosen:
            names = [one.signal for one in chosen]
            caption = "The signals that differ most. The dashed line marks where the runs diverge."
            yield "Signals", caption, svg(_both_signals(diff, names))


def _both_ways(diff: PairDiff, robots: Sequence[str]) -> Figure:
    figure = Figure(figsize=(_WIDE / 2, _WIDE / 2), layout="constrained")
    axes = figure.add_subplot(xlabel="x (m)", ylabel="y (m)")
    axes.set_aspect("equal", adjustable="datalim")
    for number, run in enumerate((diff.one, diff.other)):
        for robot in robots:
            x, y = run.motion(robot).values[:, :2].T
            axes.plot(x, y, color=colour(number), linewidth=1, alpha=0.8)
            axes.plot(x[-1:], y[-1:], "o", color=colour(number), markersize=4)
    return figure


def _both_signals(diff: PairDiff, names: Sequence[str]) -> Figure:
    figure = Figure(figsize=(_WIDE, 0.4 + 1.25 * len(names)), layout="constrained")
    stack = np.atleast_1d(figure.subplots(len(names), sharex=True))
    first = diff.divergence.first
    signals = {name: values for name, *values in common_signals(diff.one, diff.other)}
    for axes, name in zip(stack, names, strict=True):
        axes.set_title(name)
        times_s, *both = signals[name]
        for number, values in enumerate(both):
            axes.plot(times_s, values, color=colour(number), linewidth=0.9, alpha=0.85)
        if first is not None:
            axes.axvline(first.t_ns * 1e-9, color=INK, linestyle="--", linewidth=0.8)
    stack[-1].set_xlabel("simulated time (s)")
    return figure


def _records(diff: RecordsDiff) -> Iterator[tuple[str, str, str]]:
    """Return the figure of a run and old records."""
    chosen = sorted(diff.signals, key=lambda one: one.agrees)[:_MAX_STRIPS]
    figure = Figure(figsize=(_WIDE, 0.4 + 1.25 * len(chosen)), layout="constrained")
    with style():
        stack = np.atleast_1d(figure.subplots(max(len(chosen), 1)))
        for axes, one in zip(stack, chosen, strict=False):
            axes.set_title(one.name)
            for number, values in enumerate((one.one, one.old)):
                axes.plot(one.times, values, color=colour(number), linewidth=0.9, alpha=0.85)
        yield "Signals", "Blue the run, red the old records, over their times.", svg(figure)


def records_page(diff: RecordsDiff) -> str:
    """Return the page of a run and old records."""
    return _render("records.html.j2", diff=diff, figures=list(_records(diff)), words=report)


def grid_page(diff: GridDiff) -> str:
    """Return the page of a grid."""
    return _render("grid.html.j2", diff=diff, figures=list(grid_figures(diff)), words=report, steps=timesteps)


def evidence_page(found: Evidence, link: Callable[[GridCell], str], played: Collection[GridCell]) -> str:
    """Return the page of an experiment and its controls.

    Args:
        found: the comparison.
        link: the address of the recording of a run, or of a page that plays it.
        played: the runs with such a page.
    """

    def value(judged: Judgement, part: JudgedPart, wiring: str) -> str:
        values = [value for cell in part.cells if cell.wiring == wiring for value in cell.values]
        if getattr(judged.metric, "is_share", False):
            return f"in {sum(values):.0f} of {len(values)} runs"
        return (
            f"on average {report.number(float(np.mean(values)), judged.metric.unit)}" if values else "never"
        )

    description = str(next(iter(found.diff.runs.values())).settings.get("description") or "")
    return _render(
        "evidence.html.j2", found=found, figures=list(grid_figures(found.diff)), words=report, about=about,
        link=link, played=played, value=value, verdicts=report.VERDICTS, note=description,
    )  # fmt: skip


def pair_page(diff: PairDiff) -> str:
    """Return the page of two recordings."""
    return _render("pair.html.j2", diff=diff, figures=list(pair_figures(diff)), words=report)


def _render(template: str, **about: Any) -> str:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("nrp_lab.comparison"),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(**about)
