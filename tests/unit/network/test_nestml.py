"""Cells of NESTML come from a program of its own; plugins/nrp-nestml tests what it prints."""

from __future__ import annotations

from pathlib import Path

import pytest
from golden import Golden

from nrp_core.brain import builder
from nrp_core.errors import NetworkError


@pytest.mark.parametrize(
    ("says", "message"),
    [
        (None, "a.nestml.*NESTML"),
        ('echo \'{"error": "line 3: no"}\'', r"a.nestml: line 3: no"),
        ("echo broken >&2; exit 4", ""),
    ],
)
def test_a_program_that_is_missing_or_fails_is_one_error(
    says: str | None, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    (tmp_path / "a.nestml").write_text("")
    monkeypatch.setattr("sys.executable", str(tmp_path / "python"))
    monkeypatch.setenv("PATH", str(tmp_path))
    if says is not None:
        (tmp_path / "nrp-nestml").write_text(f"#!/bin/sh\n{says}\n")
        (tmp_path / "nrp-nestml").chmod(0o755)
    with golden.raises(NetworkError, match=message):
        builder().nestml_cell(tmp_path / "a.nestml")
