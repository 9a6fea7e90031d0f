"""The how-to page for ROS: its programs for ROS 2 run."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from conftest import Ros2, needs_ros2

PAGE = Path(__file__).parents[3] / "docs" / "howto" / "use-ros.md"
BLOCK = re.compile(
    r"<!-- not run: needs (?:ROS 2|the plugin) -->\n```(sh|python)\n(.*?)^```$", re.MULTILINE | re.DOTALL
)
BLOCKS = BLOCK.findall(PAGE.read_text())
FILE_NAME = re.compile(r"# ([\w.]+)\n")


@needs_ros2
@pytest.mark.slow
@pytest.mark.parametrize(
    "program",
    [
        pytest.param(text, marks=[pytest.mark.heavy] if "nrp run" in text or "conformance" in text else [])
        for language, text in BLOCKS
        if language == "sh"
    ],
)
def test_a_program_of_the_page_runs(ros2: Ros2, program: str) -> None:
    for language, text in BLOCKS:
        if language == "python":
            named = FILE_NAME.match(text)
            assert named is not None
            (ros2.folder / named[1]).write_text(text)
    nrp = ros2.folder / "nrp"
    nrp.write_text(f'#!/bin/sh\nexec {sys.executable} -m nrp_core "$@"\n')
    nrp.chmod(0o755)
    ros2.env["PATH"] = f"{ros2.folder}:{Path(sys.executable).parent}:{ros2.env['PATH']}"
    ending = "trap 'kill $(jobs -p) 2>/dev/null || true' EXIT\n"  # also of a bridge in the background
    ros2.run("bash", "-ec", ending + program, timeout_s=600)
