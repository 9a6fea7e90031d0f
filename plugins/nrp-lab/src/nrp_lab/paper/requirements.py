"""What the runs of an archive need, from the dependencies that they recorded."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from collections.abc import Iterable, Mapping
from importlib.metadata import distribution
from itertools import chain
from pathlib import Path
from typing import Any
from urllib.parse import urlparse
from urllib.request import url2pathname

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


def write_wheels(lines: Iterable[str], folder: Path) -> list[str]:
    """Write the wheel of each distribution of this project, which no package index may have.

    Return the distributions that could not be built.

    A clone that is installed in place is built; of others, what was installed is put together again.

    Args:
        lines: lines of a ``requirements.txt``.
        folder: a folder that exists.
    """
    missing = []
    for name in (line.partition("==")[0] for line in lines if line.startswith("nrp-")):
        origin = json.loads(distribution(name).read_text("direct_url.json") or "{}")
        if origin.get("dir_info", {}).get("editable"):
            command = [sys.executable, "-P", "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
            source = url2pathname(urlparse(origin["url"]).path)
            if subprocess.run(command, cwd=source, check=False, capture_output=True).returncode:
                missing.append(name)
        else:
            _put_together(name, folder)
    return missing


def _put_together(name: str, folder: Path) -> None:
    found = distribution(name)
    files = [
        file
        for file in found.files or ()
        if ".." not in file.parts
        and file.suffix != ".pyc"
        and file.name not in ("INSTALLER", "REQUESTED", "RECORD", "direct_url.json")
    ]
    target = folder / f"{name.replace('-', '_')}-{found.version}-py3-none-any.whl"
    record = f"{target.stem.removesuffix('-py3-none-any')}.dist-info/RECORD"
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as wheel:
        for file in files:
            wheel.write(str(file.locate()), file.as_posix())
        lines = [
            f"{file.as_posix()},{f'{h.mode}={h.value}' if (h := file.hash) else ''},{file.size or ''}"
            for file in files
        ]
        wheel.writestr(record, "\n".join([*lines, f"{record},,"]) + "\n")
