"""Scripts of Brian2, and the activity of their groups in the loop."""

from collections.abc import Callable
from pathlib import Path

import pytest
from command_fixtures import nrp
from nrp_core import brains
from nrp_core.brain import Brain
from nrp_core.experiment import network_from

__all__ = ["nrp"]
pytest_plugins = ["cases", "golden"]  # in tests/shared

CELLS = """
from brian2 import *

def build():
    cells = NeuronGroup(6, 'dv/dt = (20*mV - v + R*I)/tau : volt (unless refractory)\\nI : amp',
                        threshold='v > 10*mV', reset='v = 0*mV', refractory=2*ms, method='exact')
    cells.v = 'rand()*10*mV'
    return cells

tau, R = 10*ms, 10*Mohm
cells = build()
first = cells[:2]
kicks = Synapses(cells, cells, on_pre='v += 0.5*mV', delay=1*ms)
kicks.connect('i != j', p=0.5)
"""


@pytest.fixture
def script(tmp_path: Path) -> Callable[[str], Path]:
    """Write a script that has some cells in Brian2."""

    def write(end: str) -> Path:
        path = tmp_path / "cells.py"
        path.write_text(CELLS + end)
        return path

    return write


@pytest.fixture
def opened() -> Callable[..., Brain]:
    """Open a script in the backend."""

    def open_(path: Path, **options: object) -> Brain:
        backend = brains().load("brian2")
        network = network_from(path, simulator="brian2")
        return backend.open(network, seed=1, options=backend.options.model_validate(options))

    return open_
