"""Figures of a sweep: a curve with its spread over the seeds, a heat map, or parallel coordinates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.recording.figures import check_target, save
from nrp_core.recording.figures.style import DPI, FAINT, colour, style
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.table import Group, SweepTable, short_key, unit_of

_SIZE = (7.2, 4.6)
_MAX_LINES = 7  # distinguishable colours
_AXES_OF_MAP = 2
_NEEDS = {
    "curve": (1, "a curve"),
    "heat": (_AXES_OF_MAP, "a heat map"),
    "parallel": (1, "parallel coordinates"),
}
"""The number of settings that vary in a figure, and its name."""
_MAX_CELLS_WITH_NUMBERS = 150
_MAX_NAMED = 12
_COLOURS = "viridis"


def draw(
    table: SweepTable,
    path: Path,
    measure: str | None = None,
    kind: str | None = None,
    *,
    overwrite: bool = False,
) -> None:
    """Draw a sweep into a file.

    Args:
        table: the sweep.
        path: the suffix chooses between PNG, SVG and PDF.
        measure: the measure to show; by default the first.
        kind: ``curve``, ``heat`` or ``parallel``; by default by the number of settings that vary.
        overwrite: whether to replace an existing file.

    Raises:
        ExperimentError: the measure or kind is unknown, too few settings vary, or the file exists or cannot
            be written.
    """
    check_target(path, overwrite=overwrite)
    name = table.measure(measure)
    kind = kind or _usual(table)
    _require_keys(table.keys, kind)
    with style():
        figure = Figure(_SIZE, dpi=DPI, layout="constrained")
        axes = figure.subplots()
        _KINDS[kind](figure, axes, table, name)
        seeds = max((len(group.rows) for group in table.groups), default=0)
        axes.set_title(f"{table.name}: {name}" + (f", {seeds} runs each" if seeds > 1 else ""))
        save(figure, path)


def require_figure(plan: Plan, measure: str | None, kind: str | None) -> None:
    """Refuse a figure that the runs of a plan will not give, before they are made.

    Raises:
        ExperimentError: the measure or kind is unknown, or too few settings vary.
    """
    _require_keys(tuple(plan.sweep.sampled), kind or "curve")
    if measure is None:
        return
    metric = measure.partition(".")[0]
    known = plan.parts.get(metric, [])
    if known is not None and measure not in known:
        names = [name for parts in plan.parts.values() for name in parts or ()]
        raise ExperimentError(f"'{measure}' is not measured{did_you_mean(measure, known or names)}")


def _usual(table: SweepTable) -> str:
    varying = len(table.keys)
    if varying == _AXES_OF_MAP and all(_is_number(table, key) for key in table.keys):
        return "heat"
    return "curve" if varying <= _AXES_OF_MAP else "parallel"


def _curve(_: Figure, axes: Axes, table: SweepTable, name: str) -> None:
    """Draw the mean against a setting, with a band of one standard deviation, and a line per other value."""
    numeric = [key for key in table.keys if _is_number(table, key)]
    key = (numeric or list(table.keys))[0]
    lines: dict[str, list[Group]] = {}
    for group in table.groups:
        others = ", ".join(f"{short_key(k, table.keys)} {v}" for k, v in group.values.items() if k != key)
        lines.setdefault(others, []).append(group)
    ticks, kind = _ticks(table, key), "o-" if key in numeric else "o"
    for number, (label, groups) in enumerate(list(lines.items())[:_MAX_LINES]):
        groups = sorted(groups, key=lambda group: ticks[str(group.values[key])])
        x = np.array([ticks[str(group.values[key])] for group in groups])
        mean = np.array([group.mean(name) for group in groups])
        spread = np.array([group.spread(name) for group in groups])
        axes.fill_between(x, mean - spread, mean + spread, color=colour(number), alpha=0.15, linewidth=0)
        axes.plot(x, mean, kind, color=colour(number), markersize=4, linewidth=1.4, label=label)
        for at, group in zip(x, groups, strict=True):
            values = group.numbers(name)
            axes.plot([at] * len(values), values, ".", color=colour(number), alpha=0.35, markersize=3)
    _label(axes, table, key)
    axes.set_ylabel(_with_unit(name))
    axes.grid(axis="y")
    if len(lines) > 1:
        more = f"\nand {len(lines) - _MAX_LINES} more, not drawn" if len(lines) > _MAX_LINES else ""
        axes.legend(title=more or None)


def _heat(figure: Figure, axes: Axes, table: SweepTable, name: str) -> None:
    """Draw the mean against two settings, averaged over all others."""
    across, up = table.keys[:_AXES_OF_MAP]
    columns, lines = _ticks(table, across), _ticks(table, up)
    x, y = (
        {text: n for n, text in enumerate(sorted(ticks, key=ticks.__getitem__))} for ticks in (columns, lines)
    )
    values: list[list[list[float]]] = [[[] for _ in x] for _ in y]
    for group in table.groups:
        values[y[str(group.values[up])]][x[str(group.values[across])]] += group.numbers(name)
    means = np.array([[np.mean(cell) if cell else np.nan for cell in line] for line in values])
    image = axes.imshow(means, origin="lower", aspect="auto", cmap=_COLOURS)
    figure.colorbar(image, ax=axes, label=_with_unit(name)).outline.set_visible(False)
    if means.size <= _MAX_CELLS_WITH_NUMBERS:
        for (row, column), value in np.ndenumerate(means):
            dark = np.isfinite(value) and (value - np.nanmin(means)) < 0.6 * np.ptp(means[np.isfinite(means)])
            text = f"{value:.3g}" if np.isfinite(value) else "-"
            axes.text(
                column, row, text, ha="center", va="center", color="white" if dark else "black", fontsize=7
            )
    axes.set_xticks(range(len(x)), list(map(_short, x)))
    axes.set_yticks(range(len(y)), list(map(_short, y)))
    axes.set_xlabel(short_key(across, table.keys))
    axes.set_ylabel(short_key(up, table.keys))
    axes.spines[:].set_visible(False)


def _parallel(figure: Figure, axes: Axes, table: SweepTable, name: str) -> None:
    """Draw a line per combination through all settings, coloured by the measure, which is the last axis."""
    groups = [group for group in table.groups if group.numbers(name)]
    if not groups:
        raise ExperimentError(f"no run has a value of '{name}'")
    shares = [_shares(table, key, groups) for key in table.keys]
    means = np.array([group.mean(name) for group in groups])
    scale = Normalize(float(means.min()), float(means.max()) if np.ptp(means) else float(means.min()) + 1)
    shares.append(np.asarray(scale(means)))
    places = np.arange(len(shares))
    segments = [np.column_stack([places, line]) for line in np.column_stack(shares)]
    order = np.argsort(means)  # the largest on top
    lines = LineCollection(
        [segments[n] for n in order], array=means[order], cmap=_COLOURS, norm=scale, alpha=0.6, linewidths=1.0
    )
    axes.add_collection(lines)
    for line in places.tolist():
        axes.axvline(line, color=FAINT, linewidth=0.8)
    for place, key in enumerate(table.keys):
        _name_values(axes, table, key, place)
    axes.set(xlim=(-0.3, len(shares) - 0.9), ylim=(-0.08, 1.1), yticks=[])
    axes.set_xticks(places, [*(short_key(key, table.keys) for key in table.keys), ""])  # the colours name it
    axes.spines[:].set_visible(False)
    figure.colorbar(lines, ax=axes, label=_with_unit(name)).outline.set_visible(False)


_KINDS: dict[str, Callable[[Figure, Axes, SweepTable, str], None]] = {
    "curve": _curve, "heat": _heat, "parallel": _parallel,
}  # fmt: skip


def _require_keys(keys: Sequence[str], kind: str) -> None:
    if kind not in _KINDS:
        raise ExperimentError(f"there is no figure '{kind}'{did_you_mean(kind, _KINDS)}")
    number, what = _NEEDS[kind]
    if len(keys) < number:
        raise ExperimentError(
            f"{what} needs {number} varying settings besides the seed; this sweep has {len(keys)}"
        )


def _number(value: Any) -> float | None:
    """Return a value, with or without a unit, as a number."""
    if isinstance(value, bool):
        return None
    try:
        return float(str(value).split()[0])
    except (ValueError, IndexError):
        return None


def _values(table: SweepTable, key: str) -> dict[str, Any]:
    return {str(group.values[key]): group.values[key] for group in table.groups}


def _is_number(table: SweepTable, key: str) -> bool:
    """Return whether the values of a setting are numbers in one unit."""
    values = _values(table, key).values()
    return all(_number(value) is not None and len(str(value).split()) <= 2 for value in values) and (
        len({_unit(value) for value in values}) <= 1
    )


def _unit(value: Any) -> str:
    return str(value).partition(" ")[2].strip()


def _with_unit(name: str) -> str:
    """Return a measure with the unit of its metric."""
    unit = unit_of(name)
    return f"{name} ({unit})" if unit else name


def _ticks(table: SweepTable, key: str) -> dict[str, float]:
    """Return the positions of a setting's values on an axis: numbers by value, others in sequence."""
    values = _values(table, key)
    if _is_number(table, key):
        return {text: float(_number(value) or 0.0) for text, value in values.items()}
    return {text: float(place) for place, text in enumerate(values)}


def _shares(table: SweepTable, key: str, groups: list[Group]) -> Any:
    ticks = _ticks(table, key)
    low, high = min(ticks.values()), max(ticks.values())
    return np.array([(ticks[str(group.values[key])] - low) / ((high - low) or 1.0) for group in groups])


def _name_values(axes: Axes, table: SweepTable, key: str, place: int) -> None:
    """Write the first and the last number beside an axis of parallel coordinates, or each of a few values."""
    ticks = _ticks(table, key)
    low, high = min(ticks.values()), max(ticks.values())
    for text, at in ticks.items():
        if at in (low, high) or (not _is_number(table, key) and len(ticks) <= _MAX_NAMED):
            share = (at - low) / ((high - low) or 1.0)
            up = 3 if share == 1.0 else -9 if share == 0.0 else 2
            axes.annotate(
                _short(text), (place, share), (0, up), textcoords="offset points", ha="center", fontsize=7,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
            )  # fmt: skip


def _short(text: str) -> str:
    """Return a value with at most four digits, and its unit."""
    number = _number(text)
    return text if number is None else f"{number:.4g} {_unit(text)}".strip()


def _label(axes: Axes, table: SweepTable, key: str) -> None:
    axes.set_xlabel(short_key(key, table.keys))
    if _is_number(table, key):
        for unit in {_unit(value) for value in _values(table, key).values()} - {""}:
            axes.set_xlabel(f"{short_key(key, table.keys)} ({unit})")
    else:
        ticks = _ticks(table, key)
        axes.set_xticks(list(ticks.values()), list(ticks))
