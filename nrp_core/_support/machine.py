"""The machine: processor, operating system, Python and its installed packages."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

from nrp_core._support.cache import cache_root
from nrp_core._support.diagnosis import Diagnosis

if TYPE_CHECKING:
    from packaging.requirements import Requirement

DISTRIBUTION = "nrp-core"
CPU_FEATURES = ("sse4_2", "avx", "avx2", "fma", "avx512f")
"""Instruction sets that engines use; results may differ in the last bit between them."""


def describe_machine() -> dict[str, object]:
    """Return the properties of the machine that results may depend on, package versions aside."""
    flags = cpu_flags() or frozenset()
    return {
        "platform": platform.platform(),
        "architecture": platform.machine(),
        "processor": _cpuinfo().get("model name", platform.processor()),
        "cpu_features": [feature for feature in CPU_FEATURES if feature in flags],
        "cores": os.cpu_count(),
        "python": f"{platform.python_implementation()} {platform.python_version()}",
    }


def cores() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def distributions() -> dict[str, str]:
    """Return name and version of each installed package.

    They are taken from the names of the ``dist-info`` folders, which is a hundred times faster than reading
    all metadata; if two have the same name, the one that is imported counts.
    """
    found: dict[str, str] = {}
    for info in (info for entry in sys.path for info in Path(entry).glob("*.dist-info")):
        name, _, installed = info.stem.partition("-")
        found.setdefault(name.replace("_", "-"), installed)
    return dict(sorted(found.items()))


def cpu_flags() -> frozenset[str] | None:
    """Return the processor's instruction sets by their Linux names, or None if unknown."""
    flags = _cpuinfo().get("flags")
    return None if flags is None else frozenset(flags.split())


def diagnose() -> list[Diagnosis]:
    """Check this machine for the platform itself; backends have their own checks."""
    return [*_processor(), _display(), _cache(), _confinement(), *_packages()]


def _processor() -> Iterator[Diagnosis]:
    cores = os.cpu_count() or 1
    together = "brain and world step at once" if cores > 1 else "brain and world step one after the other"
    yield Diagnosis("more than one core", cores > 1, f"{cores} here: {together}")
    flags = cpu_flags()
    if flags is not None:
        has_avx = "avx" in flags
        meaning = "run" if has_avx else "may end with 'illegal instruction'"
        yield Diagnosis("AVX instructions", has_avx, f"compiled engines {meaning}")


def _display() -> Diagnosis:
    shown = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return Diagnosis("a display", shown, "windows can be opened" if shown else "none; nothing here needs one")


def _cache() -> Diagnosis:
    folder = cache_root()
    writable = _can_write(folder)
    kept = "compiled kernels, converted meshes and results of checks are"
    return Diagnosis(f"a cache folder ({folder})", writable, f"{kept} {'' if writable else 'not '}kept")


def _confinement() -> Diagnosis:
    """Look whether the process that executes brain scripts for checks can be confined."""
    from nrp_core._support.probe import run_module  # used only here

    done = run_module("nrp_core._support.confinement", timeout_s=30.0, has_folder=True)
    how = done.output.strip() or "the check failed"
    if done.exit_code == 0:
        meaning = f"nrp validate and nrp map execute scripts confined: {how}"
        return Diagnosis("confined brain scripts", True, meaning)
    meaning = f"nrp validate and nrp map do not execute scripts, unless --trust is given: {how}"
    return Diagnosis("confined brain scripts", False, meaning)


def _can_write(folder: Path) -> bool:
    nearest = next(parent for parent in (folder, *folder.parents) if parent.exists())
    return os.access(nearest, os.W_OK)


def _packages() -> Iterator[Diagnosis]:
    """Check the requirements of the platform on this Python and system."""
    from packaging.requirements import Requirement  # slow to import, and used only here

    for line in importlib.metadata.requires(DISTRIBUTION) or ():
        requirement = Requirement(line)
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            yield _package(requirement)


def _package(requirement: Requirement) -> Diagnosis:
    remedy = f"pip install '{requirement.name}{requirement.specifier}'"
    try:
        installed = version(requirement.name)
    except PackageNotFoundError:
        return Diagnosis(requirement.name, False, "not installed", remedy)
    fits = requirement.specifier.contains(installed, prereleases=True)
    meaning = installed if fits else f"{installed}; nrp-core was written for {requirement.specifier}"
    return Diagnosis(requirement.name, fits, meaning, remedy)


def _cpuinfo() -> dict[str, str]:
    """Return the first value of each entry of ``/proc/cpuinfo``; empty elsewhere than on Linux."""
    entries: dict[str, str] = {}
    path = Path("/proc/cpuinfo")
    for line in path.read_text().splitlines() if path.is_file() else ():
        key, _, value = line.partition(":")
        entries.setdefault(key.strip(), value.strip())
    return entries
