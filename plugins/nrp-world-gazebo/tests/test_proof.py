"""The log of the tests in Gazebo is that of the present sources."""

from hashlib import sha256
from pathlib import Path

PLUGIN = Path(__file__).parents[1]
DIGITS = 64  # of a SHA-256


def test_the_sources_in_c_are_those_that_were_tested_in_gazebo():
    """If this fails, run ``scripts/gazebo test`` and commit its log."""
    words = [line.split() for line in (PLUGIN / "proof.log").read_text().splitlines()]
    logged = {row[1]: row[0] for row in words if len(row) == 2 and len(row[0]) == DIGITS}
    files = sorted(path for path in (PLUGIN / "gazebo").iterdir() if path.is_file())
    assert {path.name: sha256(path.read_bytes()).hexdigest() for path in files} == logged
