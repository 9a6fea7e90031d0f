"""Gazebo and NEST engines on our worlds and brains."""

from __future__ import annotations

import json
from math import exp
from pathlib import Path

import pytest
from configurations import Write, functions

from nrp_core import Run, load_experiment

ROOM = """<sdf version="1.6"><world name="room">
  <plugin name="nrp" filename="NRPGazeboGrpcWorldPlugin.so"/>
  <light name="sun" type="directional"><direction>0 0 -1</direction></light>
  <model name="floor"><static>true</static><link name="link">
    <collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
  <model name="wall"><static>true</static><pose>2 0 0.5 0 0 0</pose><link name="link">
    <visual name="v"><geometry><box><size>0.1 4 1</size></box></geometry>
      <material><diffuse>1 0 0 1</diffuse><ambient>1 0 0 1</ambient></material></visual></link></model>
</world></sdf>"""
ARM = """<sdf version="1.6"><model name="arm">
  <link name="base"><inertial><mass>10</mass></inertial>
    <sensor name="eye" type="camera"><pose>0 0 0.5 0 0 0</pose><update_rate>50</update_rate>
      <camera><horizontal_fov>1</horizontal_fov><image><width>8</width><height>6</height></image>
        <clip><near>0.1</near><far>10</far></clip></camera>
      <plugin name="p" filename="NRPGazeboGrpcCameraControllerPlugin.so"/></sensor></link>
  <link name="wheel"><pose>0 0 1 0 0 0</pose><inertial><mass>1</mass>
    <inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link>
  <joint name="fixed" type="fixed"><parent>world</parent><child>base</child></joint>
  <joint name="spin" type="revolute"><parent>base</parent><child>wheel</child>
    <axis><xyz>0 0 1</xyz><limit><lower>-1e16</lower><upper>1e16</upper></limit></axis></joint>
  <plugin name="joints" filename="NRPGazeboGrpcJointControllerPlugin.so">
    <spin P="10" I="0" D="0" Type="velocity" Target="0" IMax="0" IMin="0"/></plugin>
</model></sdf>"""
BALL = """<sdf version="1.6"><model name="ball"><link name="body">
  <inertial><mass>1</mass></inertial>
  <collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>
  <plugin name="p" filename="NRPGazeboGrpcModelControllerPlugin.so"/></model></sdf>"""
BRAIN = """
    import nest
    from nrp_core.engines.nest_json import CreateDataPack, RegisterDataPack
    from nrp_core.engines.nest_json import brain_devices as bd

    nest.ResetKernel()
    leaky = {"C_m": 1000.0, "tau_m": 10.0, "E_L": 0.0, "V_m": 0.0, "V_th": 1e10}
    cell = nest.Create("iaf_psc_alpha", 1, leaky)
    RegisterDataPack("cell", cell)
    bd.DCSource(nest, "current", cell)
    noise = CreateDataPack("noise", "poisson_generator", 2)
    counter = CreateDataPack("counter", "spike_recorder")
    relay = nest.Create("parrot_neuron", 2)
    nest.Connect(noise, relay, "one_to_one")
    nest.Connect(relay, counter)
"""
WATCH = """
    import json
    import numpy as np
    from nrp_core import *
    from nrp_core.data.nrp_json import JsonDataPack
    from nrp_core.data.nrp_protobuf import GazeboJointDataPack, GazeboModelDataPack

    seen = []

    @EngineDataPack(keyword="joint", id=DataPackIdentifier("arm::spin", "gazebo"))
    @EngineDataPack(keyword="image", id=DataPackIdentifier("arm::base::eye", "gazebo"))
    @EngineDataPack(keyword="ball", id=DataPackIdentifier("ball", "gazebo"))
    @EngineDataPack(keyword="link", id=DataPackIdentifier("ball::body", "gazebo"))
    @SimulationIteration(keyword="n")
    @TransceiverFunction("gazebo")
    def watch(joint, image, ball, link, n):
        pixels = None if image.isEmpty() else np.frombuffer(image.data.imageData, np.uint8).reshape(6, 8, 3)
        seen.append({
            "velocity": joint.data.velocity,
            "ball": list(ball.data.position),
            "link": list(link.data.position),
            "new": image.isUpdated(), "pixel": None if pixels is None else pixels[3, 4].tolist(),
        })
        with open("seen.json", "w") as file:
            json.dump(seen, file)
        command = GazeboJointDataPack("arm::spin", "gazebo")
        command.data.velocity = 3.0
        placed = GazeboModelDataPack("ball", "gazebo")
        if n == 5:
            placed.data.position.extend([1.0, 1.0, 5.0])
        return [command, placed]
"""
BRAIN_WATCH = """
    import json
    from nrp_core import *
    from nrp_core.data.nrp_json import JsonDataPack

    voltages = []

    @EngineDataPack(keyword="cell", id=DataPackIdentifier("cell", "nest"))
    @EngineDataPack(keyword="counter", id=DataPackIdentifier("counter", "nest"))
    @TransceiverFunction("nest")
    def watch(cell, counter):
        voltages.append([cell.data[0]["V_m"], counter.data[0]["n_events"]])
        with open("voltages.json", "w") as file:
            json.dump(voltages, file)
        current = JsonDataPack("current", "nest")
        current.data["amplitude"] = 100.0
        noise = JsonDataPack("noise", "nest")
        noise.data.append({"rate": 1000.0})
        noise.data.append({"rate": 0.0})
        return [current, noise]
"""
GAZEBO = {
    "EngineType": "gazebo_grpc", "EngineName": "gazebo", "GazeboWorldFile": "room.sdf",
    "GazeboSDFModels": [
        {"Name": "arm", "File": "arm.sdf"}, {"Name": "ball", "File": "ball.sdf", "InitPose": "0 -1 1 0 0 0"},
    ],
}  # fmt: skip
NEST = {"EngineType": "nest_json", "EngineName": "nest", "NestInitFileName": "brain.py"}


@pytest.fixture
def husky_like(write: Write) -> Path:
    """Return an experiment with both sides."""
    path = write(
        {
            "SimulationTimeout": 0.2,
            "EngineConfigs": [GAZEBO, NEST],
            "DataPackProcessingFunctions": functions("watch", "brain_watch"),
        },
        brain=BRAIN, watch=WATCH, brain_watch=BRAIN_WATCH,
    )  # fmt: skip
    for name, text in {"room": ROOM, "arm": ARM, "ball": BALL}.items():
        path.with_name(f"{name}.sdf").write_text(text)
    return path


@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
def test_joints_cameras_and_models_are_those_of_the_world(husky_like: Path, world: str) -> None:
    with Run(load_experiment(husky_like, [f"world.backend={world}"])) as run:
        run.run()
    seen = json.loads(husky_like.with_name("seen.json").read_text())
    assert len(seen) == 20
    assert seen[0]["velocity"] == 0.0
    assert seen[0]["pixel"] is None
    assert seen[-1]["velocity"] == pytest.approx(3.0, rel=0.02)  # 10 N m s on 0.1 kg m2: 10 ms
    assert [one["new"] for one in seen[2:10]].count(True) == 4  # 50 images a second
    red, green, blue = seen[-1]["pixel"]
    assert red > 100 > 50 > max(green, blue)
    assert seen[5]["ball"][:2] == [0.0, -1.0]
    assert seen[6]["ball"] == pytest.approx([1.0, 1.0, 5.0], abs=0.02)
    assert seen[6]["ball"] == seen[6]["link"]


def test_devices_set_and_read_the_brain(husky_like: Path) -> None:
    with Run(load_experiment(husky_like)) as run:
        run.run()
    voltages, counts = zip(*json.loads(husky_like.with_name("voltages.json").read_text()), strict=True)
    # a current of I into a leaky cell: V = I tau / C (1 - exp(-t / tau)) = 1 mV (1 - exp(-t / 10 ms))
    expected = [1.0 - exp(-k) for k in range(20)]
    assert voltages == pytest.approx(expected, abs=0.02)
    assert 120 < counts[-1] < 270  # 1000 Hz for 190 ms


def test_an_imported_experiment_does_the_same(husky_like: Path, tmp_path: Path) -> None:
    from nrp_ebrains.reader import import_configuration

    with Run(load_experiment(husky_like)) as run:
        run.run()
        spikes = run.spikes
    import_configuration(husky_like, tmp_path / "imported")
    with Run(load_experiment(tmp_path / "imported")) as run:
        run.run()
        assert run.spikes == spikes
    assert (tmp_path / "imported" / "seen.json").read_text() == husky_like.with_name("seen.json").read_text()
