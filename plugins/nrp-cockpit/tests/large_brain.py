"""An experiment with a generated brain: a ring of cells in space, in which packets of spikes go round."""

from __future__ import annotations

from pathlib import Path

BRAIN = '''\
"""A ring of cells. Each spike makes the next four cells fire, so packets go round for ever."""

import numpy as np

import nrp_core.pynn as sim

CELLS, PACKETS = {cells}, {packets}

sim.setup(timestep=1.0)
angle = np.linspace(0, 2 * np.pi, CELLS, endpoint=False)
far = 300 + 40 * np.random.default_rng(1).standard_normal((2, CELLS))
ring = sim.Population(CELLS, sim.IF_curr_exp(tau_refrac=20.0), label="ring")
ring.positions = np.stack([far[0] * np.cos(angle), far[0] * np.sin(angle), far[1] - 300])
next_cells = [(cell, (cell + step) % CELLS) for step in range(1, 5) for cell in range(CELLS)]
static = sim.StaticSynapse(weight=6.0, delay=1.0)
sim.Projection(ring, ring, sim.FromListConnector(next_cells), static, label="next")
kicks = sim.Population(PACKETS, sim.SpikeSourceArray(spike_times=[10.0]), label="kicks")
begins = [(packet, packet * CELLS // PACKETS) for packet in range(PACKETS)]
kick = sim.StaticSynapse(weight=40.0, delay=1.0)
sim.Projection(kicks, ring, sim.FromListConnector(begins), kick, label="kick")
east = ring[: CELLS // 8]
west = ring[CELLS // 2 : CELLS // 2 + CELLS // 8]
marked = ring[:20]
'''

WORLD = """\
<sdf version="1.7"><world name="room"><model name="floor"><static>true</static><link name="link">
  <visual name="floor"><geometry><box><size>4 4 0.1</size></box></geometry></visual>
</link></model></world></sdf>
"""

EXPERIMENT = """\
name: ring
timestep: 20 ms
duration: 60 s
seed: 1
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
"""


def large_brain(folder: Path, cells: int = 2000, packets: int = 4) -> Path:
    """Write the experiment into a folder and return its file."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "brain.py").write_text(BRAIN.format(cells=cells, packets=packets))
    (folder / "room.sdf").write_text(WORLD)
    file = folder / "experiment.yaml"
    file.write_text(EXPERIMENT)
    return file
