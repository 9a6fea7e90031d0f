"""The processes in which a grid runs."""

import subprocess
import sys
from pathlib import Path

PATIENCE_S = 60.0
PROGRAM = """
import os, signal
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from nrp_core.comparison.running import _follow_parent

if __name__ == "__main__":
    pool = ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_follow_parent)
    print(pool.submit(os.getpid).result(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_process_that_runs_a_part_of_a_grid_ends_with_the_one_that_started_it(tmp_path: Path) -> None:
    """Both hold the pipe, so that its end is that of both."""
    (tmp_path / "program.py").write_text(PROGRAM)
    done = subprocess.run(
        [sys.executable, "program.py"], cwd=tmp_path, stdout=subprocess.PIPE, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == -9
    assert int(done.stdout)
