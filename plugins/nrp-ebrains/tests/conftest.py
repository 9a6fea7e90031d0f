"""Experiments of NRP-core 4, written for these tests."""

from __future__ import annotations

import json
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest
from configurations import Write


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Return a function that writes a configuration and its files, and returns the configuration's path."""

    def write(config: dict[str, Any], **files: str) -> Path:
        folder = tmp_path / "experiment"
        folder.mkdir(exist_ok=True)
        for name, text in files.items():
            (folder / f"{name}.py").write_text(dedent(text))
        path = folder / "simulation_config.json"
        path.write_text(json.dumps(config, indent="\t"))
        return path

    return write
