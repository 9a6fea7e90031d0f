"""Repeat the runs of an archive, and compare them with its recordings."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from math import dist
from pathlib import Path
from typing import Any, TypeAlias

from nrp_core.archives import unpack
from nrp_core.errors import ExperimentError
from nrp_core.recording import Recording, Replay, ReplayRequest, ReplayVerdict
from nrp_lab.paper.archive import FORMAT, MANIFEST

Poses: TypeAlias = Mapping[str, Mapping[str, float]]
"""The pose of each robot: ``x``, ``y`` and ``z`` in m."""


class Outcome(StrEnum):
    """How a repeated run compares with its recording."""

    IDENTICAL = "identical"
    """Every recorded step is equal, bit for bit."""
    EQUIVALENT = "equivalent"
    """The same criteria are met, and each robot ends within the tolerance of the archive."""
    DIFFERENT = "different"
    """Neither."""


@dataclass(frozen=True, slots=True)
class RepeatedRun:
    """A run of the archive that was executed again.

    Args:
        folder: its folder in the archive.
        outcome: how it compares.
        steps: the number of steps that were compared.
        reason: the first difference, and the distance between the robots' ends; empty if it is identical.
    """

    folder: str
    outcome: Outcome
    steps: int
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Verification:
    """The result of a verification.

    Args:
        experiment: name of the experiment.
        changed: files that are not those that were packed.
        runs: every run.
    """

    experiment: str
    changed: tuple[str, ...]
    runs: tuple[RepeatedRun, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether no file was changed and no run is different."""
        return not self.changed and all(run.outcome is not Outcome.DIFFERENT for run in self.runs)


def verify_archive(path: Path, progress: Callable[[int, int, str], None]) -> Verification:
    """Check the files of an archive, and execute its runs again; this executes code from the archive.

    Args:
        path: the archive.
        progress: called after every run with the number of finished runs, of all, and the run.

    Raises:
        ExperimentError: it is not an archive of ``nrp paper``, or of another version of its format. If a file
            was changed, nothing is executed.
    """
    folder = unpack(path)
    manifest = _read_manifest(folder, path)
    changed = tuple(_changed(folder, manifest["files"]))
    if changed:
        return Verification(manifest["experiment"], changed)
    done = []
    for run in manifest["runs"]:
        done.append(_repeat(folder, run, manifest["tolerance_m"]))
        progress(len(done), len(manifest["runs"]), run["folder"])
    return Verification(manifest["experiment"], (), tuple(done))


def _read_manifest(folder: Path, path: Path) -> dict[str, Any]:
    try:
        manifest = json.loads((folder / MANIFEST).read_text("utf-8"))
        version = manifest["format"]
    except (OSError, ValueError, KeyError, TypeError):
        raise ExperimentError("not an archive of nrp paper", path=path) from None
    if version != FORMAT:
        raise ExperimentError(f"its format is {version}; this version reads {FORMAT}", path=path)
    return dict(manifest)


def _changed(folder: Path, digests: Mapping[str, str]) -> Iterator[str]:
    for name, digest in digests.items():
        file = folder / name
        if not file.is_file() or hashlib.sha256(file.read_bytes()).hexdigest() != digest:
            yield name


def _repeat(folder: Path, run: Mapping[str, Any], tolerance_m: float) -> RepeatedRun:
    with Replay(Recording(folder / run["folder"]), ReplayRequest()) as again:
        outcome = again.go()
        result = again.run.result()
    if outcome.verdict in (ReplayVerdict.IDENTICAL, ReplayVerdict.SAME):
        return RepeatedRun(run["folder"], Outcome.IDENTICAL, outcome.steps)
    criteria = {name: one.passed for name, one in result.criteria.items()}
    kind, reason = compare_runs(run, criteria, result.final_pose, tolerance_m)
    return RepeatedRun(run["folder"], kind, outcome.steps, f"first at {outcome.difference}; {reason}")


def compare_runs(
    run: Mapping[str, Any], criteria: Mapping[str, bool | None], final_pose: Poses, tolerance_m: float
) -> tuple[Outcome, str]:
    """Judge a run whose steps differ from the recorded ones, with the reason.

    Args:
        run: the run in the manifest.
        criteria: the outcome of each criterion now.
        final_pose: the final pose of each robot now.
        tolerance_m: largest distance between final positions of equivalent runs, m.
    """
    far_m, same = _distance_m(run["final_pose"], final_pose), dict(criteria) == run["criteria"]
    kind = Outcome.EQUIVALENT if same and far_m <= tolerance_m else Outcome.DIFFERENT
    met = "the same criteria" if same else "other criteria"
    return kind, f"{met} are met, and robots end at most {far_m:.3g} m apart"


def _distance_m(recorded: Poses, now: Poses) -> float:
    """Return the largest distance between the final positions of a robot."""
    if recorded.keys() != now.keys():
        return float("inf")
    return max((dist(_place(recorded[name]), _place(now[name])) for name in recorded), default=0.0)


def _place(pose: Mapping[str, float]) -> tuple[float, float, float]:
    return pose["x"], pose["y"], pose["z"]
