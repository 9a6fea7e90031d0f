"""A cart on a rail and four cells, in files of an experiment."""

from __future__ import annotations

from pathlib import Path

BRAIN = """
import nrp_core.pynn as sim
sim.setup(timestep=0.1)
cells = sim.Population(4, sim.IF_curr_exp(tau_refrac=2.0), label="cells")
sim.Projection(cells, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.2, delay=1.0), label="net")
"""
ROOM = """
<sdf version="1.9"><world name="w"><gravity>2 0 -9.81</gravity><model name="ground"><static>true</static>
<link name="l"><collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>
</link></model></world></sdf>
"""
CART = """
<sdf version="1.9"><model name="cart"><link name="rail"/>
<link name="box"><inertial><mass>1</mass></inertial></link>
<joint name="fixed" type="fixed"><parent>world</parent><child>rail</child></joint>
<joint name="slide" type="prismatic"><parent>rail</parent><child>box</child><axis><xyz>1 0 0</xyz>
<dynamics><damping>1</damping></dynamics></axis></joint>
<plugin filename="gz-sim-apply-joint-force-system" name="gz::sim::systems::ApplyJointForce">
<joint_name>slide</joint_name></plugin></model></sdf>
"""
MOVING = """
name: ordered
timestep: 20 ms
duration: 0.3 s
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf, robots: {cart: {model: cart.sdf}}}
transfer_functions: [functions.py]
topics: {/u: std_msgs/Float64, /v: std_msgs/Float64, /w: std_msgs/Float64}
"""


def write(folder: Path, **files: str) -> Path:
    """Write files, ``__`` in whose names stands for a dot; return the path of the experiment."""
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text, "utf-8")
    return folder / "experiment.yaml"
