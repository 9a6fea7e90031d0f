"""The best candidates as experiment files, which extend the experiment that was searched."""

from __future__ import annotations

import os
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from nrp_core._support.writing import writing
from nrp_core.experiment.model.tree import Tree
from nrp_core.experiment.reading.find import load_experiment
from nrp_lab.evolve.history import History
from nrp_lab.sweep.plan import Plan, PlannedRun
from nrp_lab.sweep.running import SweepRun

BEST = "best"


def write_best(made: SweepRun, history: History) -> list[Path]:
    """Write ``best.yaml``, or with several objectives ``best_1.yaml`` and so on; return the files.

    Raises:
        ExperimentError: a file cannot be written.
    """
    best, several = history.best, history.values.shape[1] > 1
    files = []
    for place, candidate in enumerate(best, 1):
        file = made.folder / (f"{BEST}_{place}.yaml" if several else f"{BEST}.yaml")
        run = made.plan.runs[candidate * history.seeds]
        with writing(file):
            file.write_text(_header(history, candidate) + _text(made.plan, run, made.folder), "utf-8")
        files.append(file)
    for path in made.folder.glob(f"{BEST}_*.yaml"):  # of an earlier, longer front
        if path not in files:
            path.unlink()
    return files


def _header(history: History, candidate: int) -> str:
    values = ", ".join(f"{value:.6g}" for value in history.values[candidate])
    number = f"candidate {candidate % history.population} of generation {candidate // history.population}"
    return f"# Written by nrp evolve: {number}. Objective: {values}, over {history.seeds} seeds.\n"


def _text(plan: Plan, run: PlannedRun, folder: Path) -> str:
    shipped = not Path(plan.experiment).is_absolute()
    above = plan.experiment if shipped else os.path.relpath(plan.experiment, folder.resolve())
    content: dict[str, Any] = {"extends": above}
    tree = load_experiment(run.task.experiment, run.task.overrides).source
    for key in (*plan.sweep.settings, *plan.sweep.sampled):  # but not those drawn with the seed
        _set(content, tree, key.split("."))
    written = StringIO()
    yaml = YAML()
    yaml.dump(content, written)
    return written.getvalue()


def _set(content: dict[str, Any], tree: Tree, keys: list[str]) -> None:
    """Copy the value under keys; a list is copied as a whole, because files replace lists."""
    key, *rest = keys
    below = tree.value[key]
    if rest and isinstance(below.value, Mapping):
        _set(content.setdefault(key, {}), below, rest)
    else:
        content[key] = _plain(below)


def _plain(tree: Tree) -> Any:
    if isinstance(tree.value, dict):
        return {key: _plain(child) for key, child in tree.value.items()}
    return [_plain(child) for child in tree.value] if isinstance(tree.value, list) else tree.value
