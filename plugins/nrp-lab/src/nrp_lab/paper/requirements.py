"""What the runs of an archive need, as lines of a ``requirements.txt``."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, distribution, distributions, packages_distributions
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

_EXTRAS = ("models", "plot")
"""Extras of nrp-core that can decide whether a run is possible; those that are not installed are left out."""


def requirement_lines(files: Iterable[Path]) -> list[str]:
    """Return a line for each distribution that is needed, with its installed version.

    These are nrp-core, its plugins, the distributions whose modules the files import, and all that these
    require. A requirement for some systems only, such as PyBullet, keeps its marker.

    Args:
        files: Python files of the experiment; one that Python cannot parse is skipped.
    """
    providers = packages_distributions()
    roots = [f"nrp-core[{','.join(_EXTRAS)}]", "nrp-lab", *_plugins()]
    roots += (name for module in sorted(_imported(files)) for name in providers.get(module, ()))
    markers: dict[str, str] = {}
    lines: dict[str, str] = {}
    waiting = [Requirement(root) for root in roots]
    while waiting:
        wanted = waiting.pop(0)
        name = canonicalize_name(wanted.name)
        with suppress(PackageNotFoundError):
            found = distribution(name)
            if name not in lines:
                lines[name] = f"{name}=={found.version}{markers.get(name, '')}"
                waiting += _required(found.requires, ("", *wanted.extras), markers)
    return sorted(lines.values())


def _plugins() -> Iterator[str]:
    for each in distributions():
        if any(entry.group.startswith("nrp_core.") for entry in each.entry_points):
            yield each.name


def _required(
    lines: list[str] | None, extras: Iterable[str], markers: dict[str, str]
) -> Iterator[Requirement]:
    """Return the requirements that apply here, and record the marker of each new one."""
    for requirement in map(Requirement, lines or ()):
        marker = requirement.marker
        if marker is None or any(marker.evaluate({"extra": extra}) for extra in extras):
            kept = f"; {marker}" if marker is not None and "extra" not in str(marker) else ""
            markers.setdefault(canonicalize_name(requirement.name), kept)
            yield requirement


def _imported(files: Iterable[Path]) -> set[str]:
    """Return the top-level modules that files import."""
    found = set()
    for path in files:
        with suppress(SyntaxError, UnicodeDecodeError):  # Python 2, which runs after a translation
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                if isinstance(node, ast.Import):
                    found |= {alias.name.partition(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    found.add(node.module.partition(".")[0])
    return found
