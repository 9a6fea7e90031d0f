"""Time courses: colours and events, spikes, values."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from math import ceil
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.figures.story import Coloured, StepSeries, Story
from nrp_core.recording.figures.style import FAINT, colour, points

_LONGEST_LABEL, _LINE_CHARACTERS = 28, 72
_NUMBER_POINTS = 8.0
_LINES_A_TICK = 1.5
_MOST_ROWS = 400
"""Maximum number of neurons; of more, a sample is shown."""


def shade(axes: Axes, coloured: Iterable[Coloured]) -> None:
    """Shade the periods in which a visual had another colour."""
    for interval in coloured:
        axes.axvspan(
            interval.since_s, interval.until_s, facecolor=interval.rgb, alpha=0.10, linewidth=0, zorder=0
        )


def draw_timeline(axes: Axes, story: Story, coloured: Sequence[Coloured]) -> None:
    """Draw a bar for every period in which a visual had another colour, with a row for each visual."""
    visuals = list(dict.fromkeys(interval.visual for interval in coloured))
    for interval in coloured:
        row = visuals.index(interval.visual)
        width = interval.until_s - interval.since_s
        axes.broken_barh([(interval.since_s, width)], (row + 0.2, 0.6), facecolor=interval.rgb)
    axes.set_ylim(len(visuals), 0)
    axes.set_yticks([row + 0.5 for row in range(len(visuals))], [story.name_of(v) for v in visuals])
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)


@dataclass(frozen=True)
class RasterGroup:
    """Neurons that belong together in the raster: a label and, by population, their ids."""

    label: str
    population: str
    ids: tuple[int, ...]


def groups(story: Story) -> list[RasterGroup]:
    """Return the named groups of neurons, then the rest of each population.

    A neuron is shown once: in the smallest group that it belongs to.
    """
    brain = dict(story.run.get("brain") or {})
    free = {label: set(range(size)) for label, size in _sizes(story, brain).items()}
    members = [
        (name, label, sorted(i for first, last in ranges for i in range(first, last)))
        for name, populations in dict(brain.get("views") or {}).items()
        for label, ranges in populations.items()
    ]
    named: list[RasterGroup] = []
    for name, label, ids in sorted(members, key=lambda member: len(member[2])):
        own = [i for i in ids if i in free[label]]
        free[label].difference_update(own)
        rest = name if len(own) == len(ids) else f"{name} (other)"
        named += [RasterGroup(rest, label, tuple(own))] if own else []
    named.sort(key=lambda group: (group.population, group.ids))
    return named + [RasterGroup(label, label, tuple(sorted(ids))) for label, ids in free.items() if ids]


def _sizes(story: Story, brain: Mapping[str, Any]) -> dict[str, int]:
    """Return the size of each population, at least as large as the ids that have spiked."""
    sizes = {label: int(p["size"]) for label, p in dict(brain.get("populations") or {}).items()}
    for label, parts in story.spikes.items():
        seen = max((int(ids.max()) + 1 for ids, _ in parts if len(ids)), default=0)
        sizes[label] = max(sizes.get(label, 0), seen)
    return sizes


def draw_raster(axes: Axes, story: Story) -> None:
    """Draw a tick for every spike, with a row for each neuron and a colour for each group.

    The indices of the first and last neuron of each group in their population are on the right. Of large
    groups some neurons are shown, and then the title says so.
    """
    active = {label: {i for ids, _ in parts for i in ids.tolist()} for label, parts in story.spikes.items()}
    numbers: dict[float, int] = {}
    every = groups(story)
    shares = rows_of([len(group.ids) for group in every])
    if any(len(group.ids) > share for group, share in zip(every, shares, strict=True)):
        axes.set_title("Spikes (large groups: a sample, with silent neurons only where too few fire)")
    rows = 0
    labels: list[tuple[float, int, str, str]] = []  # row, rows of the group, text, colour
    for number, group in enumerate(every):
        shown = choose_neurons(group.ids, active.get(group.population, set()), shares[number])
        times, at = _spikes_of(story, group.population, shown)
        axes.plot(
            times, at + rows, "|", color=colour(number), markersize=_tick_points(axes, sum(shares)),
            markeredgewidth=_tick_width(axes, times, len(shown)), rasterized=len(times) > 20_000,
        )  # fmt: skip
        labels.append((rows + (len(shown) - 1) / 2, len(shown), group.label, colour(number)))
        numbers |= {rows: shown[0], rows + len(shown) - 1: shown[-1]}
        rows += len(shown)
        axes.axhline(rows - 0.5, color=FAINT, linewidth=0.3)
    axes.set_ylim(rows - 0.5, -0.5)
    apart = _rows_of_a_line(axes, rows)
    larger = sorted(labels, key=lambda label: -label[1])  # come first, where space is short
    written = sorted(larger[: max(1, int(rows / apart))])
    axes.set_yticks(
        separate([label[0] for label in written], apart, rows - 1.0), [label[2] for label in written]
    )
    for tick, label in zip(axes.get_yticklabels(), written, strict=True):
        tick.set_color(label[3])
    axes.tick_params(axis="y", length=0)
    _number_neurons(axes, numbers, apart)


def separate(places: Sequence[float], apart: float, last: float) -> list[float]:
    """Return ascending places with a minimum distance, moved as little as a pass from each end needs.

    Args:
        places: where labels should be, from 0 to ``last``.
        apart: the minimum distance between two.
        last: the last place, which only labels that do not all fit move beyond.
    """
    moved: list[float] = []
    for place in places:
        moved.append(max(place, moved[-1] + apart) if moved else place)
    below = last
    for i in reversed(range(len(moved))):
        moved[i] = min(moved[i], below)
        below = moved[i] - apart
    return moved


def rows_of(sizes: Sequence[int]) -> list[int]:
    """Return how many neurons of each group are shown: all of small groups, and as many of each large one."""
    fits = (most for most in range(_MOST_ROWS, 1, -1) if sum(min(size, most) for size in sizes) <= _MOST_ROWS)
    most = next(fits, 1)
    return [min(size, most) for size in sizes]


def choose_neurons(ids: Sequence[int], active: Container[int], number: int) -> list[int]:
    """Return a number of neurons of a group, evenly spaced: of those that fire, then of the silent ones."""
    firing, silent = [i for i in ids if i in active], [i for i in ids if i not in active]
    taken = _every_nth(firing, number)
    return sorted(taken + _every_nth(silent, number - len(taken)))


def _every_nth(items: Sequence[int], number: int) -> list[int]:
    count = min(number, len(items))
    return [items[i * len(items) // count] for i in range(count)]


def _rows_of_a_line(axes: Axes, rows: int) -> float:
    """Return how many rows of a raster are as high as a line of text."""
    return _NUMBER_POINTS * rows / (axes.bbox.height * 72 / axes.figure.dpi)


def _number_neurons(axes: Axes, numbers: Mapping[float, int], apart: float) -> None:
    """Write the indices of neurons beside their rows, as far as there is space."""
    written: dict[float, int] = {}
    for row, index in sorted(numbers.items()):
        if not written or row - max(written) >= apart:
            written[row] = index
    side = axes.secondary_yaxis("right")
    side.set_yticks(list(written), [str(index) for index in written.values()], fontsize=points(6.5))
    side.set_ylabel("neuron", labelpad=2)
    side.tick_params(length=2, pad=1)


def _tick_points(axes: Axes, rows: int) -> float:
    height_pt = axes.bbox.height * 72 / axes.figure.dpi
    return float(np.clip(0.8 * height_pt / max(rows, 1), 0.8, 14))


def _tick_width(axes: Axes, times: FloatArray, rows: int) -> float:
    """Return a width of ticks, points, with which they rarely overlap."""
    width_pt = axes.bbox.width * 72 / axes.figure.dpi
    return float(np.clip(0.5 * width_pt * rows / max(len(times), 1), 0.15, 0.7))


def _spikes_of(
    story: Story, population: str, shown: Sequence[int]
) -> tuple[FloatArray, npt.NDArray[np.int64]]:
    """Return times and rows of the spikes of the shown neurons."""
    parts = story.spikes.get(population, [])
    ids = np.concatenate([np.empty(0, np.int64), *(ids for ids, _ in parts)])
    times = np.concatenate([np.empty(0), *(times for _, times in parts)])
    row_of = {neuron: row for row, neuron in enumerate(shown)}
    rows = np.array([row_of.get(int(i), -1) for i in ids], np.int64)
    return times[rows >= 0], rows[rows >= 0]


def by_unit(series: Mapping[str, StepSeries]) -> dict[str, list[StepSeries]]:
    """Return series that share an axis: of one unit, or without a unit on topics with the same last name."""
    axes: dict[str, list[StepSeries]] = {}
    topics: dict[str, set[str]] = {}
    for key, one in series.items():
        topic = key.split(".")[0]
        name = one.unit or topic.rsplit("/", 1)[-1]
        axes.setdefault(name, []).append(one)
        topics.setdefault(name, set()).add(topic)
    alone = {name: min(own) for name, own in topics.items() if len(own) == 1 and not axes[name][0].unit}
    return {alone.get(name, name): own for name, own in axes.items()}


def value_rows(kind: str, series: Mapping[str, StepSeries]) -> list[tuple[str, list[StepSeries]]]:
    """Return the series that share an axis, with its title: the kind and the unit, or the topic's name."""
    return [(_title(kind, name, own), own) for name, own in by_unit(series).items()]


def _title(kind: str, name: str, own: Sequence[StepSeries]) -> str:
    return f"{kind.capitalize()} ({own[0].unit})" if own[0].unit else name


def moving(series: Mapping[str, StepSeries]) -> dict[str, StepSeries]:
    """Return the series that are not always 0; all of them if none is."""
    return {key: one for key, one in series.items() if any(one.values)} or dict(series)


def draw_series(axes: Axes, series: Sequence[StepSeries], story: Story) -> None:
    """Draw a curve for each."""
    if max(max(one.values) for one in series) >= 0:  # not of membranes, far below 0
        axes.axhline(0, color=FAINT, linewidth=0.5)
    labels = short_labels(series, min(_LONGEST_LABEL, _LINE_CHARACTERS // len(series)))
    for number, (one, label) in enumerate(zip(series, labels, strict=True)):
        times, values = [*one.times_s, story.end_s], [*one.values, one.values[-1]]
        axes.plot(
            times, values, drawstyle="steps-post", linewidth=0.9, color=colour(number),
            label=label,
        )  # fmt: skip
    lines = axes.bbox.height * 72 / axes.figure.dpi / points(_NUMBER_POINTS)
    axes.yaxis.set_major_locator(MaxNLocator(max(1, int(lines / _LINES_A_TICK)), steps=[1, 2, 5, 10]))
    axes.grid(axis="y")
    if len(series) == 1 and series[0].label == axes.get_title(loc="left"):
        return
    axes.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1, ncols=len(series), handlelength=1.1,
        columnspacing=1.2, borderpad=0.2,
    )  # fmt: skip


def short_labels(series: Sequence[StepSeries], longest: int = _LONGEST_LABEL) -> list[str]:
    """Return labels without their common parts, shortened to fit.

    Their common end is left out if the title of the axes has it (for values without a unit), or to fit.
    """
    labels = [one.label for one in series]
    if len(labels) == 1:
        labels = [label.rsplit("/", 1)[-1] if label.startswith("/") else label for label in labels]
    for borders, is_tight in (("/.", False), ("/._", True)):
        labels = _without_start(labels, borders)
        if series and (is_tight or not series[0].unit):
            labels = [label[::-1] for label in _without_start([label[::-1] for label in labels], borders)]
        if all(len(label) <= longest for label in labels):
            break
    return [label if len(label) <= longest else f"…{label[1 - longest :]}" for label in labels]


def _without_start(labels: list[str], borders: str) -> list[str]:
    """Return labels without their common beginning, up to a word boundary; a number keeps its word."""
    if len(set(labels)) < 2:
        return labels
    shared = [column[0] for column in takewhile(lambda c: len(set(c)) == 1, zip(*labels, strict=False))]
    cuts = [i + 1 for i, letter in enumerate(shared) if letter in borders]
    if cuts and all(label[cuts[-1] :].isdigit() for label in labels):
        cuts.pop()
    return [label[cuts[-1] :] for label in labels] if cuts else labels


_MOST_CURVES = 4
"""Maximum number of curves that can be distinguished and labelled."""
_ROW = 0.13
_COLUMNS = 1200
_MOST_LABELS = 24
"""Maximum number of rows with a label each."""
_LONGEST_LABEL, _LARGEST_PT, _LEAST_PT, _LINE_PT = 28, 7.0, 4.5, 140.0
"""The longest label, the sizes of labels, and the characters that fit in a line times their size."""
_LINE = 1.15
"""Height of a line in units of the size of its text."""


def height_of(series: Sequence[StepSeries], least: float) -> float:
    """Return the height of the axes of some values, in units of the smallest height."""
    return least if len(series) <= _MOST_CURVES else max(least, _ROW * min(len(series), _MOST_LABELS))


def draw_values(axes: Axes, series: Sequence[StepSeries], story: Story) -> None:
    """Draw values as steps."""
    draw = draw_series if len(series) <= _MOST_CURVES else draw_matrix
    draw(axes, series, story)


def draw_matrix(axes: Axes, series: Sequence[StepSeries], story: Story) -> None:
    """Draw a row for each series; all share the scale beside them."""
    values = np.array([resample(one, *story.span_s) for one in series])
    shown = values[np.isfinite(values)]
    low, high = (float(shown.min()), float(shown.max())) if shown.size else (0.0, 0.0)
    image = axes.imshow(
        values, cmap="cividis", aspect="auto", interpolation="nearest",
        extent=(*story.span_s, len(series), 0.0), vmin=low, vmax=high if high > low else low + 1.0,
    )  # fmt: skip
    row_pt = axes.bbox.height * 72 / axes.figure.dpi / len(series)
    every = max(-(-len(series) // _MOST_LABELS), ceil(_LINE * _LEAST_PT / row_pt))
    rows = np.arange(0, len(series), every)
    labels = short_labels(series, _LONGEST_LABEL)[::every]
    longest = max((len(label) for label in labels), default=1)
    size = np.clip(min(every * row_pt / _LINE, _LINE_PT / longest), _LEAST_PT, _LARGEST_PT)
    axes.set_yticks(rows + 0.5, labels, fontsize=float(size))
    axes.tick_params(axis="y", length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    point = axes.figure.dpi / 72 / axes.bbox.width
    scale = axes.figure.colorbar(image, cax=axes.inset_axes((1 + 4 * point, 0.0, 5 * point, 1.0)))
    scale.set_label(series[0].unit, labelpad=1, fontsize=points(7))
    scale.outline.set_visible(False)
    scale.ax.tick_params(length=2, pad=1, labelsize=points(6.5))


def resample(one: StepSeries, begin_s: float, end_s: float) -> FloatArray:
    """Return the value at equal steps of time; NaN before the first."""
    times = np.linspace(begin_s, end_s, _COLUMNS, endpoint=False)
    index = np.searchsorted(one.times_s, times, side="right") - 1
    return np.where(index >= 0, np.asarray(one.values, float)[np.maximum(index, 0)], np.nan)
