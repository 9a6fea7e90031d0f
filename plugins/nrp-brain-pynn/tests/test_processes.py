"""NEURON in an MPI job of two processes gives the spikes of one."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).with_name("spread_network.py")
MPIRUN = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", "2"]


def result_of(*launcher):
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    found = subprocess.run(
        [*launcher, sys.executable, str(SCRIPT)], capture_output=True, text=True, check=True, timeout=300,
        env=os.environ | {"PATH": path},
    )  # fmt: skip
    return next(json.loads(line) for line in found.stdout.splitlines() if line.startswith("{"))


@pytest.mark.slow
@pytest.mark.simulator("neuron")
def test_two_processes_give_the_spikes_of_one():
    one, two = result_of(), result_of(*MPIRUN)
    assert (one.pop("processes"), two.pop("processes")) == (1, 2)
    assert len(one["spikes"]) > 5000
    assert two == one
