"""A run needs nothing that only Linux has; macOS and Windows themselves are not tried here."""

import json
import subprocess
import sys
from pathlib import Path

HIDE = """
import os, signal, socket, sys
for name in ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty"):
    sys.modules[name] = None
gone = {
    os: "fork forkpty killpg setsid getpgid getuid geteuid getgid waitid "
    "sched_getaffinity sysconf uname wait4",
    signal: "SIGHUP SIGURG SIGXCPU SIGALRM SIGUSR1 pthread_kill pthread_sigmask setitimer",
    socket: "AF_UNIX",
}
import asyncio, concurrent.futures, multiprocessing, uuid, webbrowser  # have their own ways on each system
import platformdirs, numpy, scipy, numba, cv2, mujoco, neo, pyNN, quantities, rich, typer
for module, names in gone.items():
    for name in names.split():
        if hasattr(module, name):
            delattr(module, name)
"""


def test_a_run_without_the_calls_of_linux(tmp_path: Path) -> None:
    script = tmp_path / "hidden.py"
    script.write_text(HIDE + "from nrp_core.cli import main\nmain()\n")
    words = "run", "following_head", "--until", "100ms", "--record", "walk", "--json"
    command = [sys.executable, str(script), *words]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode in (0, 1), done.stderr
    assert json.loads(done.stdout)["sim_time_s"] == 0.1
    assert (tmp_path / "walk" / "recording.mcap").stat().st_size
