"""The wiring of Python functions is read from their decorators without executing them."""

from __future__ import annotations

import pytest
from nrp_bibi.reverse.wiring import Connection, connections

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

CODE = """
import hbp_nrp_client.tf_framework as nrp
from nrp_core.dsl import no_such_thing
from std_msgs.msg import Float64

1 / 0
cells = nrp.brain.wheels[2:]

for leg in ("left", "right"):
    @nrp.MapRobotSubscriber("scan", nrp.Topic("/scan", Float64))
    @nrp.MapRobotPublisher("joint", nrp.Topic(f"/{leg}_joint/cmd", Float64))
    @nrp.MapSpikeSource("eye", nrp.map_neurons(range(2), lambda i: nrp.brain.eyes[i]), nrp.poisson)
    @nrp.MapSpikeSink("wheel", cells, nrp.population_rate, tau_fall=50.0)
    @nrp.MapSpikeSink("unknown", found(), nrp.population_rate)
    @nrp.MapVariable("count", initial_value=0)
    @nrp.Neuron2Robot(nrp.Topic("/speed", Float64))
    def move(t, scan, joint, eye, wheel, unknown, count):
        return Float64(1.0)
"""


def test_every_decorator_that_connects_is_found() -> None:
    found = {one.variable: one for one in connections(CODE)}
    kind = "std_msgs.msg.Float64"
    assert found == {
        "scan": Connection("move", "scan", "/scan", kind, True, False),
        "joint": Connection("move", "joint", "/{leg}_joint/cmd", kind, True, True, is_pattern=True),
        "eye": Connection("move", "eye", "eyes", "poisson", False, True, neurons="eyes"),
        "wheel": Connection("move", "wheel", "wheels", "population_rate", False, False, neurons="wheels[2:]"),
        "": Connection("move", "", "/speed", kind, True, True),
    }


def test_text_that_is_not_python_has_no_connections() -> None:
    assert connections("def (") == []
    assert connections("\0") == []


@pytest.mark.parametrize("name", ["slalom_pioneer", "reaching_arm", "following_head"])
def test_shipped_functions_have_the_topics_and_devices_of_their_run(name: str) -> None:
    experiment = load_experiment(name)
    found = [one for path in experiment.transfer_functions for one in connections(path.read_text())]
    with Run(experiment) as run:
        published = {topic.name for function in run.loop.functions for topic in function.published}
        devices = {port.name.split("/")[1] for port in run.brain.devices if "/" in port.name}
    assert {one.target for one in found if one.is_topic and one.is_written} == published
    assert {one.variable for one in found if not one.is_topic} >= devices
