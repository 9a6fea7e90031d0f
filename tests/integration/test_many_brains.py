"""Many Huskies with brains of three kinds in one world: each brain does what it does alone.

The engine solves the contacts of all bodies together, so their poses agree to rounding; cameras, which see
the surroundings of their own body, give the same images.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from nrp_core.brain import SpikeRecorder
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

SHIPPED = Path(str(files("nrp_experiments")))
SPACING_M = 25.0
"""Farther than the cameras see, so that no robot sees or meets another one."""
LEARNER = """
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
cell = sim.Izhikevich(a=0.02, b=0.2, c=-65.0, d=8.0, i_offset=0.006)
eyes, wheels = (sim.Population(2, cell, label=label) for label in ("eyes", "wheels"))
rule = sim.STDPMechanism(
    timing_dependence=sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=0.05, A_minus=0.04),
    weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=20.0),
    weight=10.0,
    delay=1.0,
)
sim.Projection(eyes, wheels, sim.AllToAllConnector(), rule, receptor_type="excitatory")
"""
KINDS = {
    "braitenberg": ((SHIPPED / "braitenberg_husky" / "brain.py").read_text(), "circuit[0:2]", "circuit[6:8]"),
    "chaser": ((SHIPPED / "chase" / "brain.py").read_text(), "eyes", "wheels"),
    "learner": (LEARNER, "eyes", "wheels"),
}
FUNCTIONS = """
@nrp.MapRobotSubscriber("camera", nrp.Topic("/{name}/camera", sensor_msgs.msg.Image))
@nrp.MapSpikeSource("eyes", nrp.brain.{name}.{eyes}, nrp.poisson, weight={weight})
@nrp.Robot2Neuron()
def {name}_sees(t, camera, eyes):
    red = nrp.tf_lib.detect_red(camera.value)
    eyes.rate = 400.0 * (red.left + red.right)


@nrp.MapSpikeSink("left", nrp.brain.{name}.{wheels}[0], nrp.population_rate)
@nrp.MapSpikeSink("right", nrp.brain.{name}.{wheels}[1], nrp.population_rate)
@nrp.Neuron2Robot(nrp.Topic("/{name}/cmd_vel", geometry_msgs.msg.Twist))
def {name}_moves(t, left, right):
    linear = geometry_msgs.msg.Vector3(0.3 + 0.002 * min(left.rate, right.rate), 0, 0)
    return geometry_msgs.msg.Twist(linear, geometry_msgs.msg.Vector3(0, 0, 0.01 * (right.rate - left.rate)))

"""
WEIGHTS = {"braitenberg": 0.0005, "chaser": 1.0, "learner": 10.0}


def kind_of(robot: int) -> str:
    return [*KINDS][robot % 3]


def write(folder: Path, robots: list[int], of: int, duration: str) -> Path:
    """Write an experiment with some of the robots and the red pillars of all, one before each place."""
    folder.mkdir()
    husky = (SHIPPED / "braitenberg_husky" / "husky.sdf").read_text()
    (folder / "husky.sdf").write_text(husky.replace("<far>100</far>", "<far>8</far>"))
    for kind, (brain, *_) in KINDS.items():
        (folder / f"{kind}.py").write_text(brain)
    floor = (SHIPPED / "chase" / "floor.sdf").read_text()
    pillars = "".join(
        f"""<model name="pillar{n}"><static>true</static><pose>{x + 4} {y + 0.1 * (n % 7)} 1 0 0 0</pose>
        <link name="link"><visual name="red"><geometry><box><size>0.5 0.5 2</size></box></geometry><material>
        <diffuse>1 0 0 1</diffuse><emissive>0.5 0 0 1</emissive></material></visual></link></model>"""
        for n, (x, y) in enumerate(map(place, range(of)))
    )
    (folder / "floor.sdf").write_text(floor.replace("</world>", f"{pillars}</world>"))
    code = "import geometry_msgs.msg\nimport sensor_msgs.msg\n\nimport nrp_core.dsl as nrp\n\n"
    for robot in robots:
        kind = kind_of(robot)
        _, eyes, wheels = KINDS[kind]
        code += FUNCTIONS.format(name=f"h{robot}", eyes=eyes, wheels=wheels, weight=WEIGHTS[kind])
    (folder / "functions.py").write_text(code)
    models = ", ".join(f"h{robot}: {kind_of(robot)}.py" for robot in robots)
    bodies = "".join(
        f"    h{robot}: {{model: husky.sdf, pose: [{place(robot)[0]}, {place(robot)[1]}, 0.2, 0, 0, 0]}}\n"
        for robot in robots
    )
    (folder / "experiment.yaml").write_text(
        f"name: huskies\ntimestep: 20 ms\nduration: {duration}\nseed: 3\n"
        f"brain:\n  backend: event\n  model: {{{models}}}\n"
        "world:\n  backend: mujoco\n  scene: floor.sdf\n  options: {image_scale: 0.2}\n"
        f"  robots:\n{bodies}transfer_functions: [functions.py]\n"
    )
    return folder


def place(robot: int) -> tuple[float, float]:
    return SPACING_M * (robot % 10), SPACING_M * (robot // 10)


def trains(folder: Path) -> dict[str, list[tuple[int, float]]]:
    """Return the spikes of each brain by the name of its robot: numbers of its cells, and times, ms."""
    with Run(load_experiment(folder)) as run:
        network = run.brain.network
        recorder = run.brain.add_sink(SpikeRecorder(), np.arange(network.size), name="all")
        run.run()
        found = recorder.spikes()  # type: ignore[attr-defined]
        owners = np.repeat(
            [label.partition(".")[0] for label in network.populations],
            [one.size for one in network.populations.values()],
        )
        result = {}
        for name in dict.fromkeys(owners.tolist()):
            first = int(np.flatnonzero(owners == name)[0])
            of_it = owners[found.neurons] == name
            neurons = (found.neurons[of_it] - first).tolist()
            result[name] = list(zip(neurons, found.times_ms[of_it].tolist(), strict=True))
        return result


@pytest.mark.parametrize(
    ("robots", "duration"), [(4, "0.5 s"), pytest.param(50, "5 s", marks=pytest.mark.heavy)]
)
def test_each_brain_fires_as_it_does_without_the_others(tmp_path: Path, robots: int, duration: str) -> None:
    together = trains(write(tmp_path / "all", [*range(robots)], robots, duration))
    assert len(together) == robots
    for robot in range(robots):
        alone = trains(write(tmp_path / f"{robot}", [robot], robots, duration))
        assert alone == {f"h{robot}": together[f"h{robot}"]}
    assert all(len(spikes) > 5 for spikes in together.values())
