"""Write the archive: runs, figures, methods, verdict, and how to repeat it."""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from nrp_core.errors import ExperimentError
from nrp_core.experiment import prepare
from nrp_core.recording import Recording
from nrp_core.utilities import replacing, writing
from nrp_lab.comparison.grid import ORIGINAL, GridCell, RunGrid, run_grid
from nrp_lab.comparison.metric import Margins, all_metrics
from nrp_lab.comparison.report import grid_data, headline
from nrp_lab.comparison.result import GridDiff
from nrp_lab.comparison.signals import RunSignals
from nrp_lab.paper.latex import latex_tables
from nrp_lab.paper.methods import methods_page, template
from nrp_lab.paper.places import in_neutral_places, make_anonymous, neutral_places
from nrp_lab.paper.requirements import files_elsewhere, requirement_lines, write_wheels

FORMAT: Final = 1
MANIFEST: Final = "paper.json"
RUNS: Final = "runs"
WHEELS: Final = "wheels"
TOLERANCE_M: Final = 0.01
"""Largest distance between final positions of a robot on two machines whose floating point differs."""
_FIGURES: Final = ("run", "raster", "trajectory", "devices")
_DATE: Final = (1980, 1, 1, 0, 0, 0)
"""The date of each file in the archive, so that equal contents give equal archives."""

Progress = Callable[[int, int, str], None]
"""Called with the number of finished runs, the number of all runs, and the last finished run."""


def write_archive(grid: RunGrid, target: Path, workers: int, progress: Progress) -> dict[str, Any]:
    """Run an experiment from all seeds and under all conditions, and write the archive.

    Args:
        grid: the runs.
        target: a .zip file; it is replaced.
        workers: number of processes.
        progress: called after every run.

    Returns:
        The contents of the manifest.

    Raises:
        NrpError: the experiment cannot be opened.
        ExperimentError: the target is not a .zip file, or the file cannot be written.
    """
    if target.suffix.lower() != ".zip":
        raise ExperimentError(f"an archive is a .zip file, not '{target.name}'")
    with TemporaryDirectory(prefix="nrp-paper-") as scratch:
        folder = Path(scratch)
        runs = run_grid(grid, folder / RUNS, workers, progress)
        verdict = _write_verdict(grid, runs, folder)
        first = Recording(grid.folder(folder / RUNS, grid.cells[0]))
        _write_figures(first, folder / "figures")
        plan = prepare(grid.load(grid.cells[0]))
        conditions = tuple(grid.label(one) for one in grid.conditions)
        page = methods_page(plan, first.run["settings"], grid.seeds, conditions)
        (folder / "methods.md").write_text(page, "utf-8")
        recorded = {cell: Recording(grid.folder(folder / RUNS, cell)).run for cell in grid.cells}
        manifest = _manifest(grid, recorded, verdict)
        lines = requirement_lines(recorded.values())
        (folder / "requirements.txt").write_text("\n".join(lines) + "\n", "utf-8")
        (folder / "tables.tex").write_text(latex_tables(page), "utf-8")
        (folder / WHEELS).mkdir()
        _write_readme(manifest, folder, write_wheels(lines, folder / WHEELS))
        places = neutral_places(first.run["file"].removeprefix("experiment"))
        for cell in grid.cells:
            make_anonymous(grid.folder(folder / RUNS, cell))
        for file in (path for path in folder.iterdir() if path.is_file()):
            file.write_text(in_neutral_places(file.read_text("utf-8"), places), "utf-8")
        manifest["files"] = _digests(folder)
        text = in_neutral_places(json.dumps(manifest, indent=1), places)
        (folder / MANIFEST).write_text(text, "utf-8")
        _pack(folder, target)
    return manifest


def _write_verdict(grid: RunGrid, runs: Mapping[GridCell, RunSignals], folder: Path) -> str | None:
    """Write the verdict of ``nrp diff`` on the runs, and return its headline; None without two conditions."""
    if len(grid.conditions) < 2 or len(grid.seeds) < 2:
        return None
    from nrp_lab.comparison.report_page import grid_page  # with Matplotlib, which a reviewer need not have

    metrics = all_metrics()
    found = GridDiff.of(grid, runs, metrics, Margins.parse((), metrics), folder / RUNS)
    (folder / "verdict.html").write_text(grid_page(found), "utf-8")
    (folder / "verdict.json").write_text(json.dumps(grid_data(found), indent=1, default=str), "utf-8")
    return headline(found)


def _write_figures(recording: Recording, folder: Path) -> None:
    """Draw the first run, and each part of it that it has."""
    folder.mkdir()
    for what in _FIGURES:
        try:
            recording.plot(what, folder / f"{what}.svg")
        except ExperimentError:
            if what == "run":
                raise


def _manifest(
    grid: RunGrid, recorded: Mapping[GridCell, Mapping[str, Any]], verdict: str | None
) -> dict[str, Any]:
    runs = []
    for cell, run in recorded.items():
        result = dict(run.get("result") or {})
        runs.append({
            "folder": grid.folder(Path(RUNS), cell).as_posix(),
            "brain": cell.brain, "world": cell.world, "seed": cell.seed,
            "control": None if cell.wiring == ORIGINAL else cell.wiring, "state": run.get("state"),
            "criteria": {name: one["passed"] for name, one in dict(result.get("criteria") or {}).items()},
            "final_pose": result.get("final_pose") or {},
        })  # fmt: skip
    first = recorded[grid.cells[0]]
    return {
        "format": FORMAT, "experiment": first["experiment"], "verdict": verdict, "tolerance_m": TOLERANCE_M,
        "runs": runs, "elsewhere": files_elsewhere(recorded.values()),
        "distributions": dict(first.get("distributions") or {}),
        "machine": dict(first.get("machine") or {}),
    }  # fmt: skip


def _write_readme(manifest: Mapping[str, Any], folder: Path, missing: Sequence[str]) -> None:
    figures = sorted(path.name for path in (folder / "figures").iterdir())
    text = template("readme.md.j2").render(**manifest, figures=figures, missing=missing)
    (folder / "README.md").write_text(text, "utf-8")


def _digests(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of each file by its path in the archive."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths
    }


def _pack(folder: Path, target: Path) -> None:
    with (
        writing(target),
        replacing(target) as draft,
        zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED) as packed,
    ):
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            entry = zipfile.ZipInfo(path.relative_to(folder).as_posix(), _DATE)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            packed.writestr(entry, path.read_bytes())
