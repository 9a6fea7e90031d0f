"""Files that are written as a whole."""

from __future__ import annotations

import os
import resource
from pathlib import Path

import pytest

from nrp_core.errors import ExperimentError
from nrp_core.utilities import replace_file

OLD = "x = 1\n"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "functions.py"
    path.write_text(OLD)
    return path


def test_a_file_is_replaced_and_keeps_its_permissions(file: Path) -> None:
    file.chmod(0o640)
    replace_file(file, "y = 'é'\r\n")
    assert file.read_bytes() == "y = 'é'\r\n".encode()
    assert file.stat().st_mode & 0o777 == 0o640
    replace_file(file.with_name("new.bin"), b"\x00\xff")
    assert sorted(one.name for one in file.parent.iterdir()) == ["functions.py", "new.bin"]


def test_a_link_stays_a_link(file: Path) -> None:
    link = file.with_name("link.py")
    link.symlink_to(file)
    replace_file(link, "y = 2\n")
    assert (link.is_symlink(), file.read_text()) == (True, "y = 2\n")


def test_a_full_disk_leaves_the_old_file_and_no_draft(file: Path) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        with pytest.raises(ExperimentError, match="cannot be written"):
            replace_file(file, "y" * 10_000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert file.read_text() == OLD
    assert [one.name for one in file.parent.iterdir()] == [file.name]


def test_a_file_that_may_only_be_read_is_left(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: (path, mode) != (file, os.W_OK))  # root may do all
    with pytest.raises(ExperimentError, match="Permission denied"):
        replace_file(file, "y = 2\n")
    assert file.read_text() == OLD
