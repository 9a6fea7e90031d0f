"""A run is made again when anything that it read has changed, and only then."""

import importlib.metadata
import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest
from nrp_lab.comparison.grid import RunGrid, is_reusable, run_grid
from nrp_lab.sweep.executor import LocalExecutor
from nrp_lab.sweep.model import sweep_of
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.running import SweepRun

from nrp_core._support import packages
from nrp_core.experiment import tree_of
from nrp_core.recording.folder import dependencies

FILES = {
    "experiment.yaml": """
extends: base.yaml
brain: {backend: event, model: brain.py}
transfer_functions: [tf.py, model.bibi]
""",
    "base.yaml": """
name: reads_everything
timestep: 20 ms
duration: 60 ms
models: [models]
world:
  backend: mujoco
  scene: room.sdf
  robots:
    post:
      model: post.urdf.xacro
      pose: [3, 0, 0.5, 0, 0, 0]
      add_sensors: [{type: pressure_gauge, link: post}]
""",
    "brain.py": """
import os
from pathlib import Path
import h5py
import numpy as np
import pyNN.nest as sim
import own_library
from neighbour import SIZE
here = Path(__file__).parent
sim.setup(timestep=0.1)
offset = float(np.loadtxt(here / "offset.txt")) + own_library.OFFSET + float(os.environ.get("BIAS", 0))
with open(here / "tau.txt") as file:
    tau = float(file.read())
with h5py.File(here / "matrix.h5") as file:
    offset += file["w"][0]
for table in sorted(here.glob("tables/*.csv")):
    offset += float(table.read_text())
cells = sim.Population(SIZE, sim.IF_curr_exp(i_offset=offset, tau_m=tau), label="cells")
""",
    "neighbour.py": "SIZE = 8\n",
    "offset.txt": "0.5",
    "tau.txt": "20",
    "tables/a.csv": "0.1",
    "tf.py": """
from pathlib import Path
import hbp_nrp_client.tf_framework as nrp
from gains import RATE
@nrp.MapSpikeSource("drive", nrp.brain.cells, nrp.poisson, weight=3.0)
@nrp.Robot2Neuron()
def f(t, drive):
    import later
    drive.rate = RATE * later.FACTOR * float((Path(__file__).parent / "factor.txt").read_text())
""",
    "gains.py": "from lower import RATE\n",
    "lower.py": "RATE = 100.0\n",
    "later.py": "FACTOR = 2\n",
    "factor.txt": "1",
    "room.sdf": """<sdf version="1.9"><world name="room">
<include><uri>model://ground_plane</uri></include>
<include><uri>model://ball</uri><pose>1 0 1 0 0 0</pose></include>
<model name="picture"><static>true</static><link name="l"><visual name="v">
  <geometry><box><size>1 0.1 1</size></box></geometry>
  <material><pbr><metal><albedo_map>picture.png</albedo_map></metal></pbr></material></visual></link></model>
<model name="triangle"><static>true</static><link name="l"><collision name="c"><geometry><polyline>
  <point>0 0</point><point>1 0</point><point>0 1</point><height>0.1</height></polyline></geometry></collision>
</link></model>
</world></sdf>""",
    "models/ball/model.config": "<model><name>ball</name><sdf version='1.9'>model.sdf</sdf></model>",
    "models/ball/model.sdf": """<sdf version="1.9"><model name="ball"><link name="l">
<collision name="c"><geometry><mesh><uri>model://ball/ball.obj</uri></mesh></geometry></collision>
</link></model></sdf>""",
    "models/ball/ball.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    "post.urdf.xacro": """<robot name="post" xmlns:xacro="http://ros.org/wiki/xacro">
<xacro:include filename="size.xacro"/>
<link name="post"><inertial><mass value="$(optenv POST_MASS 2)"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="${size} ${size} 1"/></geometry></collision></link></robot>""",
    "size.xacro": """<robot xmlns:xacro="http://ros.org/wiki/xacro">
<xacro:property name="size" value="0.2"/></robot>""",
    "model.bibi": """<bibi xmlns="http://schemas.humanbrainproject.eu/SP10/2014/BIBI"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <transferFunction xsi:type="Robot2Neuron" name="second">
    <device name="current" type="DCSource">
      <neurons xsi:type="Population" population="cells"/><body xsi:type="Constant" value="0.1"/>
    </device>
  </transferFunction></bibi>""",
}
GAUGE = """
from nrp_core.world.sensors.navigation import AirPressure

class Gauge(AirPressure):
    pass
"""
"""Files that are changed by appending a text that keeps their meaning, and what the texts are."""
APPENDED = {
    "experiment.yaml": "#\n", "base.yaml": "#\n", "brain.py": "#\n", "neighbour.py": "#\n",
    "offset.txt": "1", "tau.txt": ".5", "tables/a.csv": "1", "tf.py": "#\n", "gains.py": "#\n",
    "lower.py": "#\n", "later.py": "#\n", "factor.txt": ".5", "room.sdf": "\n", "models/ball/model.sdf": "\n",
    "models/ball/ball.obj": "\n", "post.urdf.xacro": "\n", "size.xacro": "\n", "model.bibi": "\n",
}  # fmt: skip

Change = Callable[[], None]


@pytest.fixture
def folder(tmp_path: Path, install: Callable[..., None], site: Path) -> Path:
    """The experiment, a plugin with a sensor, and two modules on the path of Python."""
    install("pressure_gauge", "[nrp_core.sensors]\npressure_gauge = pressure_gauge:Gauge\n", GAUGE)
    (site / "own_library.py").write_text("import own_lower\nOFFSET = own_lower.OFFSET\n")
    (site / "own_lower.py").write_text("OFFSET = 0.25\n")
    for name, text in FILES.items():
        path = tmp_path / "experiment" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    with h5py.File(tmp_path / "experiment" / "matrix.h5", "w") as file:
        file["w"] = np.array([0.1])
    cv2.imwrite(str(tmp_path / "experiment" / "picture.png"), np.full((4, 4, 3), 200, np.uint8))
    return tmp_path / "experiment"


@contextmanager
def appended(path: Path, data: bytes) -> Iterator[None]:
    before = path.read_bytes()
    path.write_bytes(before + data)
    _forget()
    yield
    path.write_bytes(before)
    _forget()


@contextmanager
def added(path: Path) -> Iterator[None]:
    path.write_text("0.2")
    yield
    path.unlink()


@contextmanager
def patched(change: Callable[[pytest.MonkeyPatch], None]) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        change(patch)
        yield


def _forget() -> None:
    """Forget what a new process would not know."""
    packages.fingerprint.cache_clear()


def _version_of(package: str, patch: pytest.MonkeyPatch) -> None:
    real = importlib.metadata.version
    patch.setattr(importlib.metadata, "version", lambda name: "9.9" if name == package else real(name))


def _code_of_backend(patch: pytest.MonkeyPatch) -> None:
    real = packages.fingerprint
    patch.setattr(dependencies, "fingerprint", lambda name: "" if name == "nrp_world_mujoco" else real(name))


def changes(folder: Path, site: Path) -> Iterator[tuple[str, object]]:
    """Yield a word of the message, and a context in which one thing is different."""
    for name, text in APPENDED.items():
        yield Path(name).name, appended(folder / name, text.encode())
    for name in ("matrix.h5", "picture.png"):
        yield name, appended(folder / name, b"\0")
    for name in ("own_library", "own_lower", "pressure_gauge"):
        yield name, appended(site / f"{name}.py", b"#\n")
    yield "tables", added(folder / "tables" / "b.csv")
    yield "BIAS", patched(lambda patch: patch.setenv("BIAS", "0.5"))
    yield "POST_MASS", patched(lambda patch: patch.setenv("POST_MASS", "3"))
    yield "GAZEBO_MODEL_PATH", patched(lambda patch: patch.setenv("GAZEBO_MODEL_PATH", str(folder)))
    for name in ("numpy", "xacro", "mapbox-earcut"):
        yield f" {name} ", patched(partial(_version_of, name))
    yield "nrp_world_mujoco", patched(_code_of_backend)


@pytest.mark.heavy
def test_a_sweep_and_a_comparison_repeat_a_run_after_a_change_of_anything_that_it_read(
    folder: Path, site: Path, caplog: pytest.LogCaptureFixture
) -> None:
    experiment = str(folder / "experiment.yaml")
    described = tree_of({"experiment": experiment, "measure": ["activity"]})

    def sweep() -> SweepRun:
        return SweepRun(Plan.of(sweep_of(described)), folder.parent / "sweep")

    made = sweep()
    executor = LocalExecutor()
    executor.workers = 1
    with executor:
        made.run(executor)
    assert [row["error"] for row in made.rows] == [None]
    grid = RunGrid.of(experiment, [], [], 1)
    run_grid(grid, folder.parent / "results", 1, lambda *_: None)
    recording = grid.folder(folder.parent / "results", grid.cells[0])

    assert (sweep().pending, sweep().news) == ([], "")
    assert is_reusable(recording, grid.file)
    reused, named = [], 0
    for word, change in changes(folder, site):
        with change, caplog.at_level(logging.WARNING):  # type: ignore[attr-defined]
            caplog.clear()
            again = sweep()
            if not again.pending or word not in again.news:
                reused.append(f"sweep: {word}: {again.news}")
            if is_reusable(recording, grid.file) or word not in caplog.text:
                reused.append(f"comparison: {word}: {caplog.text}")
            named += 1
    assert (reused, named) == ([], 31)
    assert (sweep().pending, is_reusable(recording, grid.file)) == ([], True)
    sys.modules.pop("own_library"), sys.modules.pop("own_lower")
