"""A Gazebo that is killed, hangs or has another plugin is one clear error, and nothing is left behind."""

import os
import signal
import subprocess
import sys

import pytest
from nrp_world_gazebo import GazeboBackend

from nrp_core.errors import BackendLoadError, SimulationError
from nrp_core.world import Inertial, Link, Model, Scene

pytestmark = [pytest.mark.heavy, pytest.mark.usefixtures("gazebo")]
SCENE = Scene((Model("box", (Link("link", inertial=Inertial(1.0)),)),))


def opened(**options):
    backend = GazeboBackend()
    return backend.open(SCENE, seed=1, options=backend.options.model_validate(options))


def test_a_gazebo_that_is_killed_is_one_error(temporary, servers):
    with opened() as world:
        (server,) = servers()
        os.kill(server, signal.SIGKILL)
        with pytest.raises(SimulationError, match=r"Gazebo ended (by signal 9|with exit code)"):
            world.run_until(20_000_000)
    assert not list(temporary.iterdir())


def test_a_gazebo_that_hangs_is_given_up_and_ended(temporary, servers, until):
    with opened(step_timeout=0.5) as world:
        world.run_until(20_000_000)
        (server,) = servers()
        os.kill(server, signal.SIGSTOP)
        with pytest.raises(SimulationError, match=r"0\.5 s.*step_timeout"):
            world.run_until(40_000_000)
    assert until(lambda: not servers())
    assert not list(temporary.iterdir())


def test_a_plugin_of_another_version_is_refused(servers, until, monkeypatch):
    monkeypatch.setattr("nrp_world_gazebo.process.VERSION", 99)
    with pytest.raises(BackendLoadError, match=r"99.*scripts/gazebo"):
        opened()
    assert until(lambda: not servers())


PROGRAM = """
import tempfile, time
tempfile.tempdir = {folder!r}
from nrp_core.world import Inertial, Link, Model, Scene
from nrp_world_gazebo import GazeboBackend
scene = Scene((Model("box", (Link("link", inertial=Inertial(1.0)),)),))
world = GazeboBackend().open(scene, seed=1, options=GazeboBackend.options())
print("open", flush=True)
time.sleep(600)
"""


def test_a_hanging_gazebo_does_not_outlive_a_killed_python(temporary, servers, until):
    program = PROGRAM.format(folder=str(temporary))
    python = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert python.stdout.readline() == "open\n"
    (server,) = servers()
    os.kill(server, signal.SIGSTOP)
    python.kill()
    python.wait()
    python.stdout.close()
    assert until(lambda: not servers())
