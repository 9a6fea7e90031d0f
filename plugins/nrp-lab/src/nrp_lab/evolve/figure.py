"""The figure of a search: values by generation, or the front of two objectives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nrp_core._support.writing import writing
from nrp_core.recording.figures import UNDATED, check_target
from nrp_core.recording.figures.style import FAINT, colour, style
from nrp_lab.evolve.history import History

_SIZE = (7.2, 4.2)


def draw(history: History, path: Path) -> None:
    """Draw a search into a file; the suffix chooses between PNG, SVG and PDF.

    Raises:
        ExperimentError: the file cannot be written.
    """
    check_target(path)
    with style():
        figure = Figure(_SIZE, layout="constrained")
        axes = figure.subplots()
        if history.values.shape[1] == 1:
            _course(axes, history)
        else:
            _front(axes, history)
        names = axes.get_legend_handles_labels()
        figure.legend(*names, loc="outside lower center", ncols=3)  # where it covers nothing
        figure.suptitle(f"{history.name}: {len(history)} generations of {history.population} candidates")
        with writing(path):
            figure.savefig(path, dpi=150, metadata=UNDATED.get(path.suffix.lower()))


def _course(axes: Axes, history: History) -> None:
    """Draw all candidates, the mean with one standard deviation, and the best so far."""
    values = history.generations[:, :, 0]
    generations = np.arange(len(values))
    course = {name: numbers[:, 0] for name, numbers in history.course.items()}
    mean, sd = course["mean"], course["sd"]
    every = np.repeat(generations, values.shape[1])
    axes.plot(every, values.ravel(), ".", color=FAINT, markersize=3, label="candidates")
    axes.fill_between(generations, mean - sd, mean + sd, color=colour(0), alpha=0.15, linewidth=0)
    axes.plot(generations, mean, color=colour(0), linewidth=1.2, label="mean ± sd")
    axes.step(
        generations, course["best_so_far"], where="post", color=colour(1), linewidth=1.6, label="best so far"
    )
    axes.set(xlabel="generation", ylabel="objective")
    axes.grid(axis="y")


def _front(axes: Axes, history: History) -> None:
    """Draw the first two objectives of all candidates, and the front."""
    x, y = history.values[:, 0], history.values[:, 1]
    front = history.best
    axes.plot(x, y, ".", color=FAINT, markersize=3, label="candidates")
    axes.plot(x[front], y[front], "o-", color=colour(1), markersize=4, linewidth=1.2, label="best")
    axes.set(xlabel="objective 1", ylabel="objective 2")
    axes.grid()
