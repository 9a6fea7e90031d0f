"""The number of doubts before a run leaves out what was converted, which the summary lists."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.cli import app

AHEAD = """@nrp.Neuron2Robot(Topic("/robot/p3dx/cmd_vel", geometry_msgs.msg.Twist))
def {}(t):
    {}
    return geometry_msgs.msg.Twist()
"""


@pytest.fixture
def doubts_of(
    corpus: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[[str], tuple[int, str]]:
    """Return a function that runs an experiment with other functions: the doubts counted, and the summary."""
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)
    monkeypatch.setenv("NRP_MODELS", str(corpus / "models"))

    def of(functions: str) -> tuple[int, str]:
        folder = corpus / "p3dx_2018"
        (folder / "drive.py").write_text(functions)
        app.run_app(["run", str(folder), "--until", "20ms", "--overwrite"])
        said = capsys.readouterr()
        counted = re.search(r"note: (\d+) warnings?[ ,]", said.err)
        return 0 if counted is None else int(counted[1]), said.out

    return of


def test_only_warnings_are_counted(doubts_of: Callable[[str], tuple[int, str]]) -> None:
    plain, _ = doubts_of(AHEAD.format("drive", "pass"))
    converted, told = doubts_of(AHEAD.format("drive", "if t < 0: print 'back'"))
    assert "leftovers of Python 2 were converted" in told
    assert converted == plain
    doubted, told = doubts_of(AHEAD.format("drive", "pass") + "\n\n" + AHEAD.format("too", "pass"))
    assert "[NRP229]" in told
    assert doubted == plain + 1
