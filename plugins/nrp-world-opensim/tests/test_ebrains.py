"""A script of NRP-core 4 with the simulator Opensim drives a model as OpenSim alone does."""

import json
from pathlib import Path

import nrp_core
import numpy as np
import opensim as osim

from own_models import arm, written

SCRIPT = """
from nrp_core.engines.py_sim import PySimEngineScript

class Script(PySimEngineScript):
    def initialize(self):
        self._registerDataPack("joints")
        self._setDataPack("joints", {"elbow": 0})

    def runLoop(self, timestep_ns):
        self.sim_manager.run_step([0.8, 0.1], timestep_ns)
        elbow = self.sim_manager.get_model_property("elbow_joint", datapack_type="Joint")
        force = self.sim_manager.get_model_property("flexor", datapack_type="Force")
        with open("elbow.txt", "a") as file:
            print(self.sim_manager.get_sim_time(), elbow, force, file=file)

    def shutdown(self):
        self.sim_manager.shutdown()
"""


def test_a_script_drives_opensim_as_opensim_alone(tmp_path: Path) -> None:
    model_file = written(arm(), tmp_path)
    engine = {
        "EngineName": "arm",
        "EngineType": "py_sim",
        "EngineTimestep": 0.01,
        "PythonFileName": "swing.py",
        "Simulator": "Opensim",
        "WorldFileName": model_file.name,
        "Visualizer": False,
    }
    path = tmp_path / "simulation_config.json"
    path.write_text(
        json.dumps({"SimulationName": "arm", "SimulationTimeout": 0.1, "EngineConfigs": [engine]})
    )
    (tmp_path / "swing.py").write_text(SCRIPT)
    nrp_core.run(path)
    model = osim.Model(str(model_file))
    state = model.initSystem()
    model.equilibrateMuscles(state)
    model.setDefaultControls(osim.Vector.createFromMat(np.array([0.8, 0.1])))
    manager = osim.Manager(model)
    manager.setIntegratorAccuracy(5e-5)
    lines = (tmp_path / "elbow.txt").read_text().splitlines()
    assert len(lines) == 10
    for number, line in enumerate(lines):
        manager.initialize(state)
        state = manager.integrate((number + 1) * 10_000_000 / 1e9)
        model.realizeDynamics(state)
        elbow = model.getCoordinateSet().get("elbow").getValue(state)
        force = model.getMuscles().get("flexor").getTendonForce(state)
        np.testing.assert_allclose([*map(float, line.split())], [state.getTime(), elbow, force], atol=1e-10)
