"""The table of a ladder, its file and its figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from nrp_core.recording.figures import check_target, save
from nrp_core.recording.figures.style import DPI, colour, style
from nrp_lab.learning.ladder import BASELINES, BLOCKS, Standing
from nrp_lab.learning.tasks import TASKS
from nrp_lab.sweep.table import write_rows

TABLE, FIGURE = "learning.csv", "learning.svg"


def rows_of(standings: Sequence[Standing]) -> list[dict[str, Any]]:
    """Return a row for each condition of each task, as plain data."""
    rows = []
    for one in standings:
        low, median, high = one.quartiles
        rivals = [other for other in standings if other.task == one.task and other.condition in BASELINES]
        beats = one.better_than(rivals) if one.condition == "learned" else None
        rows.append({
            "task": one.task, "condition": one.condition, "seeds": len(one.scores), "median": median,
            "lower_quartile": low, "upper_quartile": high, "lowest": min(one.scores),
            "highest": max(one.scores), "beats_baselines": beats, "cpu_us": one.cpu_us,
            "spikes_a_step": one.spikes,
        })  # fmt: skip
    return rows


def report(standings: Sequence[Standing], console: Console) -> None:
    """Print the table."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for head in (
        "task",
        "condition",
        "score",
        "quartiles",
        "range",
        "beats baselines",
        "CPU/step",
        "spikes/step",
    ):
        table.add_column(head, justify="left" if head in ("task", "condition") else "right")
    for row in rows_of(standings):
        beats = row["beats_baselines"]
        table.add_row(
            row["task"], row["condition"], f"{row['median']:.2f}",
            f"{row['lower_quartile']:.2f} to {row['upper_quartile']:.2f}",
            f"{row['lowest']:.2f} to {row['highest']:.2f}",
            "" if beats is None else f"{beats} of {row['seeds']}",
            f"{row['cpu_us']:.0f} us", f"{row['spikes_a_step']:.0f}",
        )  # fmt: skip
    console.print(table)


def write_csv(standings: Sequence[Standing], folder: Path) -> Path:
    """Write the table into the folder of the ladder, and return the file."""
    return write_rows(folder / TABLE, rows_of(standings))


def draw(standings: Sequence[Standing], path: Path) -> Path:
    """Draw learning curves, and the tests beside them: median and quartiles over the seeds.

    Args:
        standings: those of a ladder.
        path: the file; the suffix chooses between PNG, SVG and PDF.
    """
    check_target(path, overwrite=True)
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(one.task for one in standings))
    columns = min(3, len(names))
    with style():
        figure = Figure((3.0 * columns, 2.4 * -(-len(names) // columns)), dpi=DPI, layout="constrained")
        places = np.atleast_1d(figure.subplots(-(-len(names) // columns), columns, sharey=True)).ravel()
        for axes, name in zip(places, names, strict=False):
            _draw_task(axes, [one for one in standings if one.task == name])
            axes.set_title(name)
        for axes in places[len(names) :]:
            axes.set_axis_off()
        figure.legend(*places[0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
        save(figure, path)
    return path


def _draw_task(axes: Any, standings: Sequence[Standing]) -> None:
    steps = TASKS[standings[0].task].training
    centres = (np.arange(BLOCKS) + 0.5) / BLOCKS * steps
    for number, one in enumerate(standings):
        shown = colour(number)
        low, median, high = one.quartiles
        if one.curve:
            bands = np.quantile(np.array(one.curve), (0.25, 0.5, 0.75), axis=0)
            axes.fill_between(centres, bands[0], bands[2], color=shown, alpha=0.15, linewidth=0)
            axes.plot(centres, bands[1], color=shown)
        at = steps * (1.06 + 0.05 * number)
        axes.errorbar(
            at, median, [[median - low], [high - median]], fmt="o", markersize=3.5, color=shown,
            label=one.condition,
        )  # fmt: skip
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel("steps of training, then the test")
    axes.set_ylabel("score")
