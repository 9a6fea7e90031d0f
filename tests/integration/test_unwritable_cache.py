"""A cache folder that cannot be made costs only time."""

import os
import subprocess
import sys

import pytest

PROGRAM = """
import logging
from nrp_core._support.jit import cache_folder, jit

logging.basicConfig(format="%(levelname)s %(message)s")

@jit
def double(x):
    return 2.0 * x

print(double(21.0), cache_folder().exists())
"""


@pytest.mark.one_of(3)
@pytest.mark.parametrize("variable", ["XDG_CACHE_HOME", "NUMBA_CACHE_DIR"])
def test_kernels_compile_without_a_cache_and_say_so_once(variable: str, tmp_path) -> None:
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    environment = {**os.environ, variable: "/proc/none"}
    if variable == "XDG_CACHE_HOME":
        environment.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run(
        [sys.executable, program], env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout.split()) == (0, ["42.0", "True"]), done.stderr
    assert done.stderr.count("cannot be written") == 1
