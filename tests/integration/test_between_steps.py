"""Nothing between two steps of the loop is lost: the same figures with loops of 20, 10 and 2 ms."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from cart import BRAIN, CART, MOVING, ROOM, write
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

WORLDS = pytest.mark.parametrize("world", ["mujoco", "pybullet"])
LOOPS = ("20 ms", "10 ms", "2 ms")
BALL = """
<sdf version="1.9"><model name="ball"><link name="body">
<inertial><mass>0.5</mass><inertia><ixx>0.0005</ixx><iyy>0.0005</iyy><izz>0.0005</izz></inertia></inertial>
<collision name="c"><geometry><sphere><radius>0.05</radius></sphere></geometry></collision>
<sensor name="imu" type="imu"><update_rate>1000</update_rate><topic>imu</topic></sensor></link></model></sdf>
"""
COUNTS = """
import hbp_nrp_client.tf_framework as nrp

@nrp.MapRobotSubscriber("imu", nrp.Topic("/ball/imu"))
@nrp.MapVariable("seen", initial_value=None)
@nrp.Robot2Neuron()
def counts(t, imu, seen):
    seen.value = (seen.value or []) + [(m.t, m.value.linear_acceleration.z) for m in imu.messages]

@nrp.MapRobotSubscriber("imu", nrp.Topic("/ball/imu"))
@nrp.MapVariable("seen", initial_value=None)
@nrp.Robot2Neuron(triggers=["imu"], calls="each")
def called(t, imu, seen):
    seen.value = (seen.value or []) + [(t, imu.value.linear_acceleration.z)]
"""
EXPERIMENT = """
name: between
timestep: 20 ms
duration: 2 s
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf, robots: {ball: {model: ball.sdf, pose: [0, 0, 0.95, 0, 0, 0]}},
  options: {timestep: 1 ms}}
transfer_functions: [functions.py]
topics: {/flag: std_msgs/Float64}
events:
  hit: {when: {topic: {name: /ball/imu, field: linear_acceleration.z, above: 15}}}
  there: {when: {near: {model: ball, point: [1.0, 0], within: 0.5 m}}}
  with_it: {when: {event: hit}, publish: {topic: /flag, value: 1.0}}
criteria:
  falls: {topic_stays: {name: /ball/imu, field: linear_acceleration.z, below: 15}}
  stays: {stays_within: {model: ball, distance: 0.5 m, of: start}}
  comes: {near: {model: ball, point: [1.0, 0], within: 0.5 m}}
"""


def bounces(seen: list[tuple[float, float]]) -> int:
    """The number of times at which the ball begins to touch the ground."""
    touches = [acceleration > 15 for _, acceleration in seen]
    return sum(now and not before for before, now in itertools.pairwise(touches))


@pytest.mark.one_of(3)
@WORLDS
def test_functions_events_and_criteria_see_the_same_with_any_loop(world: str, tmp_path: Path) -> None:
    file = write(
        tmp_path, experiment__yaml=EXPERIMENT, brain__py=BRAIN, room__sdf=ROOM, ball__sdf=BALL,
        functions__py=COUNTS,
    )  # fmt: skip
    found = []
    for loop in LOOPS:
        with Run(load_experiment(file, [f"world.backend={world}", f"timestep={loop}"])) as run:
            flags = run.world.subscribe("/flag", depth=None)
            run.run()
            functions, result = {one.name: one for one in run.loop.functions}, run.result()
            seen, calls = (functions[name].seen.value for name in ("counts", "called"))
            (flag,) = flags.take()
        assert len(seen) == 2001
        assert calls == seen
        assert functions["called"].name not in [failure.function for failure in run.loop.failures]
        hit_s = next(t for t, acceleration in seen if acceleration > 15)
        assert result.events["hit"] == result.events["with_it"] == hit_s
        assert 0 <= flag.t_ns - hit_s * 1e9 < run.experiment.timestep, "actions follow at the next step"
        decided = {name: (verdict.passed, verdict.decided_s) for name, verdict in result.criteria.items()}
        assert decided["falls"] == (False, hit_s)
        assert decided["comes"][1] == result.events["there"]
        found.append((seen, bounces(seen), result.events, decided))
    assert found[0] == found[1] == found[2]
    assert found[0][1] > 0


ORDERED = """
import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64

@nrp.MapSpikeSource("drive", nrp.brain.cells[0:2], nrp.dc_source)
@nrp.MapSpikeSource("noise", nrp.brain.cells, nrp.poisson, weight=0.3)
@nrp.Robot2Neuron()
def excite(t, drive, noise):
    drive.amplitude, noise.rate = 2.0 * (t > 0.05), 400.0

@nrp.MapSpikeSource("more", nrp.brain.cells[1:3], nrp.dc_source)
@nrp.Robot2Neuron()
def excite_more(t, more):
    more.amplitude = 0.7 + 0.1 * t

@nrp.MapSpikeSource("most", nrp.brain.cells[1:4], nrp.dc_source)
@nrp.Robot2Neuron()
def excite_most(t, most):
    most.amplitude = 0.3 + 0.3 * t

@nrp.MapSpikeSink("rate", nrp.brain.cells, nrp.population_rate)
@nrp.Neuron2Robot(nrp.Topic("/u", Float64))
def control(t, rate):
    return Float64(rate.rate)

@nrp.MapRobotSubscriber("u", nrp.Topic("/u", Float64))
@nrp.Neuron2Robot(nrp.Topic("/v", Float64), triggers=["u"], calls="each")
def limit(t, u):
    return Float64(min(u.value.data, 30.0))

@nrp.MapRobotSubscriber("v", nrp.Topic("/v", Float64))
@nrp.Neuron2Robot(nrp.Topic("/model/cart/joint/slide/cmd_force", Float64))
def push(t, v):
    return Float64(sum(message.value.data for message in v.messages))

@nrp.MapWeights("w", nrp.brain.projection("net"))
@nrp.Robot2Neuron()
def learn(t, w):
    w.values[:] += 0.01

@nrp.MapWeights("w", nrp.brain.projection("net"))
@nrp.Neuron2Robot(nrp.Topic("/w", Float64))
def tell(t, w):
    return Float64(float(w.values[0]))
"""
N_FUNCTIONS = ORDERED.count("def ")


def outcome(file: Path, brain: str, world: str, order: Sequence[int]) -> tuple[object, ...]:
    """All messages of the topics, the position of the cart at the end, and the spikes."""
    changes = [f"brain.backend={brain}", f"world.backend={world}"]
    with Run(load_experiment(file, changes)) as run:
        functions = list(run.loop.functions)
        run.change(remove=[function.name for function in functions])
        run.change(add=[functions[i] for i in order])
        heard = [run.world.subscribe(topic, depth=None) for topic in ("/u", "/v", "/w")]
        run.run()
        position = np.array(run.world.joint_states("cart").positions).tobytes()
        messages = [[(one.t_ns, one.message.data) for one in topic.take()] for topic in heard]
        return messages, position, run.spikes


@pytest.mark.one_of(8)
@WORLDS
@pytest.mark.parametrize("brain", ["event", "spinnaker"])
def test_any_order_of_functions_that_share_no_variable_gives_the_same_run(
    brain: str, world: str, tmp_path: Path
) -> None:
    file = write(
        tmp_path, experiment__yaml=MOVING, brain__py=BRAIN, room__sdf=ROOM, cart__sdf=CART,
        functions__py=ORDERED,
    )  # fmt: skip
    expected = outcome(file, brain, world, range(N_FUNCTIONS))
    messages, position, spikes = expected
    assert all(messages)
    assert spikes["cells"] > 0
    assert np.frombuffer(position)[0] > 0

    @settings(max_examples=4, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
    @given(st.permutations(range(N_FUNCTIONS)))
    def holds(order: list[int]) -> None:
        assert outcome(file, brain, world, order) == expected

    holds()


@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
def test_trajectory_digests_differ_when_only_a_joint_moves_differently(world: str, tmp_path: Path) -> None:
    file = write(tmp_path, experiment__yaml=MOVING, brain__py=BRAIN, room__sdf=ROOM, cart__sdf=CART)
    settings_ = [f"world.backend={world}", "transfer_functions=[]", "topics=null", "duration=100 ms"]
    found = []
    for force in (0.0, 1e-9, 0.0):
        with Run(load_experiment(file, settings_)) as run:
            run.publish("/model/cart/joint/slide/cmd_force", force)
            run.run()
            place = run.world.joint_states("cart").positions[0]
            found.append((run.result().final_pose, place, run.result().trajectory_digest))
    still, pushed, again = found
    assert still == again
    assert still[0] == pushed[0], "the base is fixed"
    assert still[1] == pytest.approx(pushed[1])
    assert still[1:] != pushed[1:]
    assert still[2] != pushed[2]
