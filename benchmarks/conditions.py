"""The conditions under which a benchmark was run, without which its figures mean little."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def conditions() -> str:
    """Return the commit, the number of cores and the load of the machine."""
    asked = ["git", "-C", str(Path(__file__).parent), "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(asked, capture_output=True, text=True, check=False).stdout.strip()
    return f"commit {commit or 'unknown'}, {os.cpu_count()} cores, {load()}"


def load() -> str:
    """Return the load of the last minute."""
    return f"load {os.getloadavg()[0]:.1f}"


def print_conditions() -> None:
    """Print the conditions beside the results, which may be read by a program."""
    print(conditions(), file=sys.stderr, flush=True)
