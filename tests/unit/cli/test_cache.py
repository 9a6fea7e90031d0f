"""The cache of the user: what is kept, and what makes room."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from nrp_core._support.cache import cached_folder, entries, prune

HOUR_S = 3600.0


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "nrp-core"


def fill(folder: Path) -> None:
    (folder / "data").write_bytes(bytes(1000))


def add(kind: str, key: str, *, unused_s: float = 0.0) -> Path:
    """Add an entry of 1000 bytes that was last used some time ago."""
    folder = cached_folder(kind, key, fill)
    last_s = time.time() - unused_s
    os.utime(folder, (last_s, last_s))
    return folder


def test_the_least_recently_used_files_are_removed_first(root: Path) -> None:
    old, older, new = (add("meshes", f"{n}", unused_s=n * HOUR_S) for n in (3, 4, 2))
    assert prune(to_bytes=2500) == 1000
    assert [path.exists() for path in (old, older, new)] == [True, False, True]
    assert prune(to_bytes=2500) == 0


def test_an_entry_that_is_used_again_is_not_the_oldest(root: Path) -> None:
    used, other = (add("meshes", f"{n}", unused_s=n * HOUR_S) for n in (3, 2))
    assert cached_folder("meshes", "3", lambda _: pytest.fail("it is kept")) == used
    prune(to_bytes=1000)
    assert (used.exists(), other.exists()) == (True, False)


def test_recently_used_files_stay_in_the_cache(root: Path) -> None:
    recent, model = add("mjcf", "a", unused_s=HOUR_S / 2), add("unpacked", "b", unused_s=48 * HOUR_S)
    assert prune(to_bytes=0) == 0
    assert recent.exists()
    assert model.exists()


def test_the_limit_is_read_from_the_environment(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for n in range(4):
        add("meshes", f"{n}", unused_s=2 * HOUR_S)
    monkeypatch.setenv("NRP_CACHE_LIMIT_MB", "0.0025")
    assert prune() == 2000


def test_the_command_shows_and_clears_the_cache(root: Path, nrp: Callable[..., Any]) -> None:
    add("meshes", "a")
    add("unpacked", "b")
    data = json.loads(nrp("cache", "--json").out)
    assert (data["folder"], data["bytes"]) == (str(root), {"meshes": 1000, "unpacked": 1000})
    assert nrp("cache", "--clear").code == 0
    assert list(entries()) == []
