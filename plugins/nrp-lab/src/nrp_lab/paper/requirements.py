"""What the runs of an archive need, from the dependencies that they recorded."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib.metadata import distribution
from itertools import chain
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from nrp_core.recording import Dependencies


def requirement_lines(runs: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return a line of a ``requirements.txt`` for each distribution that runs depended on, and nrp-lab.

    The versions are those of the runs. A requirement for some systems only, such as PyBullet, keeps its
    marker.

    Args:
        runs: the contents of their ``run.json``, all recorded with the software that is installed now.
    """
    versions = {"nrp-lab": distribution("nrp-lab").version}
    for run in runs:
        versions |= Dependencies.recorded(run).versions
    versions.pop("Python", None)
    lines = (map(Requirement, distribution(name).requires or ()) for name in versions)
    required = [one for one in chain(*lines) if one.marker is None or one.marker.evaluate({"extra": ""})]
    always = {canonicalize_name(one.name) for one in required if one.marker is None}
    markers = {str(canonicalize_name(one.name)): f"; {one.marker}" for one in required}
    return [
        f"{name}=={version}{'' if name in always else markers.get(name, '')}"
        for name, version in sorted(versions.items())
    ]


def files_elsewhere(runs: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the files that runs read outside of the experiment's folder, which their recordings lack.

    Args:
        runs: the contents of their ``run.json``.
    """
    read = {path for run in runs for path in Dependencies.recorded(run).files}
    return sorted(path for path in read if Path(path).is_absolute())
