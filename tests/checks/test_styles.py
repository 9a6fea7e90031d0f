"""Transfer functions in all the styles that people write them in: they run, and nothing is found wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.dsl.loading import load_transfer_functions
from nrp_core.dsl.testing import MockBrain, Rig
from nrp_core.findings import Level
from nrp_core.network.files.script import load_network

TOPICS = {
    "/own/left": "Float64", "/own/right": "Float64", "/own/out": "Float64", "/own/level": "Float64",
    "/husky/said/left": "String", "/husky/said/right": "String", "/own/told": "String", "/own/x": "String",
}  # fmt: skip
HELPERS = """\
GAIN = 500.0


def smooth(old, new, share=0.5):
    return old + share * (new - old)
"""
HEAD = """\
import hbp_nrp_client.tf_framework as nrp
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Image
from std_msgs.msg import Float64, String
"""

STYLES = {
    "helpers own module": """\
import helpers
from helpers import GAIN as G, smooth
@nrp.MapSpikeSource("go", nrp.brain.sensors[4], nrp.poisson)
@nrp.MapVariable("old", initial_value=0.0)
@nrp.Robot2Neuron()
def f(t, go, old):
    old.value = smooth(old.value, new=1.0, share=0.25)
    go.rate = G * old.value + helpers.GAIN
""",
    "classes": """\
class Pid:
    def __init__(self, p=1.0):
        self.p, self.sum = p, 0.0
    def __call__(self, error):
        self.sum += error
        return self.p * error + 0.1 * self.sum
@nrp.MapSpikeSink("a", nrp.brain.actors[0], nrp.population_rate)
@nrp.MapVariable("pid", initial_value=Pid(2.0))
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", Twist))
def f(t, a, pid):
    u = pid.value(a.rate - 10.0)
    return Twist(Vector3(u, 0, 0), Vector3())
""",
    "comprehension devices": """\
GROUPS = nrp.chain_neurons(*[nrp.brain.sensors[i] for i in range(3)])
@nrp.MapSpikeSource("eyes", GROUPS, nrp.poisson, weight=[0.0001 * (i + 1) for i in range(3)])
@nrp.Robot2Neuron()
def f(t, eyes):
    eyes.rate = [10.0 * i for i in range(3)]
    for i, eye in enumerate(eyes):
        eye.rate = 5.0 * i
    eyes[-1].rate = sum(eye.rate for eye in eyes[:2])
""",
    "closures": """\
def wheel(index):
    return nrp.brain.actors[index]
def sender(topic, gain=2.0):
    @nrp.MapSpikeSink("rate", wheel(0), nrp.population_rate)
    @nrp.Neuron2Robot(nrp.Topic(topic, Float64))
    def send(t, rate):
        return Float64(gain * rate.rate)
    send.name = topic
    return send
left, right = sender("/own/left"), sender("/own/right", gain=3)
more = [sender(topic) for topic in ("/own/out", "/own/level")]
""",
    "named closures": """\
def make(name, topic, gain=2.0):
    def body(t, rate):
        return Float64(gain * rate.rate)
    body.__name__ = name
    body = nrp.Neuron2Robot(nrp.Topic(topic, Float64))(body)
    return nrp.MapSpikeSink("rate", nrp.brain.actors[0], nrp.population_rate)(body)
left, right = make("a", "/own/left"), make("b", "/own/right", 3.0)
""",
    "numpy": """\
import numpy as np
M = np.array([[1.0, 0.0], [0.5, 2.0]])
@nrp.MapSpikeSink("rates", nrp.map_neurons(2, lambda i: nrp.brain.actors[i]), nrp.population_rate)
@nrp.MapVariable("state", initial_value=np.zeros(2))
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", Twist))
def f(t, rates, state):
    state.value = 0.9 * state.value + 0.1 * (M @ np.asarray(rates.rate))
    x, z = state.value
    return Twist(linear=Vector3(x=float(x)), angular=Vector3(z=float(z) % 1))
""",
    "dataclasses": """\
from dataclasses import dataclass, field, replace
@dataclass
class State:
    level: float = 0.0
    history: list = field(default_factory=list)
    @property
    def last(self):
        return self.history[-1] if self.history else None
@nrp.MapVariable("state", initial_value=State())
@nrp.MapSpikeSource("go", nrp.brain.sensors[4], nrp.poisson)
@nrp.Robot2Neuron()
def f(t, state, go):
    state.value = replace(state.value, level=state.value.level + 1)
    state.value.history.append(t)
    go.rate = state.value.level if state.value.last else 0
""",
    "f strings": """\
ROBOT = "husky"
SIDES = {"left": 0, "right": 1}
for side, i in SIDES.items():
    def body(t, rate, said):
        said.send_message(String(f"{t:.3f} {rate.rate:>8.2f}"))
    body.__name__ = f"tell_{side}"
    tf = nrp.MapSpikeSink("rate", nrp.brain.actors[i], nrp.population_rate)(
        nrp.MapRobotPublisher("said", nrp.Topic(f"/{ROBOT}/said/{side}", String))(nrp.Neuron2Robot()(body)))
""",
    "nested": """\
@nrp.MapSpikeSink("a", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapSpikeSink("b", nrp.brain.actors[1], nrp.leaky_integrator_exp)
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", Twist))
def f(t, a, b):
    def clip(x, low=-1.0, high=1.0):
        return max(low, min(high, x))
    def twist(**kw):
        return Twist(**kw)
    if t < 0.1:
        return None
    v = clip(20 * min(a.voltage, b.voltage))
    return twist(linear=Vector3(v, 0, 0), angular=Vector3(0, 0, clip(b.voltage - a.voltage, high=2.0)))
""",
    "any order": """\
@nrp.MapSpikeSink("a", nrp.brain.actors[0], nrp.spike_recorder)
@nrp.MapRobotSubscriber("camera", nrp.Topic("/husky/camera", Image))
@nrp.MapVariable("n", initial_value=0)
@nrp.MapCSVRecorder("csv", "a,b.csv", ["time", "n,m", 'quo"te'])
@nrp.MapRobotPublisher("out", nrp.Topic("/own/out", Float64))
@nrp.Robot2Neuron()
def f(t, out, csv, n, camera, a):
    if camera.changed:
        n.value += 1
    csv.record_entry(t, "1,2", 'say "hi"')
    out.send_message(Float64(n.value + len(a.times)))
""",
    "lists of devices": """\
@nrp.MapSpikeSource("a", nrp.brain.sensors[0], nrp.poisson)
@nrp.MapSpikeSource("b", nrp.brain.sensors[1], nrp.poisson)
@nrp.MapSpikeSource("c", nrp.brain.sensors[2:4], nrp.fixed_frequency)
@nrp.Robot2Neuron()
def f(t, a, b, c):
    devices = [a, b, c]
    for device, rate in zip(devices, (1.0, 2.0, 3.0)):
        device.rate = rate
    first, *rest = devices
    rest[0].rate, first.rate = 4.0, 5.0
    {"x": a}["x"].rate = 7.0
""",
    "loop declared": """\
for number, side in enumerate(("left", "right")):
    def named(function, side=side):
        function.__name__ = f"drive_{side}"
        return function
    @nrp.MapSpikeSink("v", nrp.brain.actors[number], nrp.leaky_integrator_alpha)
    @nrp.Neuron2Robot(nrp.Topic("/own/" + side, Float64))
    @named
    def drive(t, v):
        return Float64(v.voltage)
""",
    "topics between": """\
@nrp.MapSpikeSink("v", nrp.brain.actors, nrp.population_rate, tau_fall=30.0)
@nrp.Neuron2Robot(nrp.Topic("/own/level", Float64))
def first(t, v):
    return Float64(v.rate)
@nrp.MapRobotSubscriber("level", nrp.Topic("/own/level", Float64))
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", Twist), triggers="level")
def second(t, level):
    return Twist(Vector3(x=level.value.data if level.value else 0.0))
first.priority = 5
""",
    "guards": """\
@nrp.MapRobotSubscriber("camera", nrp.Topic("/husky/camera", Image))
@nrp.MapSpikeSource("go", nrp.brain.sensors[4], nrp.poisson)
@nrp.Robot2Neuron()
def f(t, camera, go):
    camera = camera.value
    if camera is None or not camera.data is not None:
        go.rate = 0
        return
    try:
        go.rate = 10.0 / (camera.width - 320)
    except ZeroDivisionError:
        go.rate = 1.0
    else:
        go.active = True
""",
    "generators walrus": """\
@nrp.MapSpikeSink("spikes", nrp.brain.sensors, nrp.spike_recorder)
@nrp.MapVariable("seen", initial_value=[])
@nrp.Robot2Neuron()
def f(t, spikes, seen):
    def recent():
        for one in spikes.times:
            yield one
    if (n := sum(1 for _ in recent())) > 3:
        seen.value += [n]
    while len(seen.value) > 10:
        seen.value.pop(0)
""",
    "lambda constants": """\
from math import pi, sin
PHASES = [i * pi / 4 for i in range(4)]
WAVE = lambda t, phase: 50.0 * (1 + sin(2 * pi * t + phase))
OFFSET = {"a": 1, "b": 2}.get("b", 0)
@nrp.MapSpikeSource("eyes", nrp.map_neurons(range(0, 4), lambda i: nrp.brain.sensors[i]), nrp.poisson)
@nrp.Robot2Neuron()
def f(t, eyes):
    eyes.rate = [WAVE(t, phase) for phase in PHASES]
""",
    "if main": """\
import os, sys
DEBUG = bool(os.environ.get("DEBUG"))
if DEBUG:
    print("debug")
try:
    import notthere
except ImportError:
    notthere = None
if sys.version_info >= (3, 8):
    RATE = 10.0
else:
    RATE = 20.0
@nrp.MapSpikeSource("go", nrp.brain.sensors[4], nrp.poisson)
@nrp.Robot2Neuron()
def f(t, go):
    go.rate = RATE if notthere is None else 0.0
if __name__ == "__main__":
    f(0.0)
""",
    "module once": """\
table = None
order = [2, 0, 1]
def loaded():
    return [10.0 * i for i in order]
@nrp.MapSpikeSource("go", nrp.brain.sensors[4], nrp.poisson)
@nrp.MapVariable("history", initial_value=[])
@nrp.Robot2Neuron()
def f(t, go, history):
    global table
    if table is None:
        table = loaded()
    history.value.append(t)
    go.rate = table[order[0]] / len(history.value)
""",
    "wraps": """\
import functools
def logged(function):
    @functools.wraps(function)
    def inner(t, go):
        return function(t, go)
    return inner
@nrp.MapSpikeSource("go", nrp.brain.sensors[4], nrp.poisson)
@nrp.Robot2Neuron()
@logged
def f(t, go):
    go.rate = 3.0
""",
    "combined decorator": """\
def wheels(function):
    function = nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", Twist))(function)
    for i, side in enumerate(("left", "right")):
        function = nrp.MapSpikeSink(side, nrp.brain.actors[i], nrp.leaky_integrator_alpha)(function)
    return function
@wheels
def drive(t, left, right):
    return Twist(Vector3(min(left.voltage, right.voltage)), Vector3(z=right.voltage - left.voltage))
""",
    "enum namedtuple": """\
from collections import namedtuple, deque
from enum import Enum
Gain = namedtuple("Gain", "linear angular")
GAIN = Gain(20.0, 100.0)
class Mode(Enum):
    SEARCH = 1
    GO = 2
@nrp.MapSpikeSink("a", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.MapVariable("mode", initial_value=Mode.SEARCH)
@nrp.MapVariable("old", initial_value=deque(maxlen=5))
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", Twist))
def f(t, a, mode, old):
    old.value.append(a.voltage)
    if t > 0.1 and mode.value is Mode.SEARCH:
        mode.value = Mode.GO
    mode = mode.value
    return Twist(Vector3(GAIN.linear * sum(old.value) * mode.value))
""",
    "custom device": """\
from nrp_core.brain.devices.sinks import PopulationRate
class Envelope(nrp.CustomDevice):
    def apply(self, neurons, brain, tau=20.0):
        self._sink = brain.add_sink(PopulationRate(tau_fall=tau), neurons.ids, name="envelope")
    @property
    def level(self):
        return self._sink.rate / len(self._sink.neurons)
@nrp.MapSpikeSink("envelope", nrp.brain.sensors, Envelope(), tau=50.0)
@nrp.Neuron2Robot(nrp.Topic("/own/level", Float64))
def listen(t, envelope):
    return envelope.level
""",
    "preprocessed": """\
def half(image):
    return 0.5 * image.width
small = nrp.PreprocessedTopic("/husky/camera", Image, half)
@nrp.MapRobotSubscriber("width", small)
@nrp.MapSpikeSource("go", nrp.brain.sensors[4], nrp.poisson)
@nrp.Robot2Neuron(throttling_rate=10)
def f(t, width, go):
    if width.value is not None:
        go.rate = 0.1 * width.value
""",
    "matching strings": """\
import re, random, json
RNG = random.Random(3)
NAMES = "told left".split()
TOPICS = ["/own/{}".format(name) for name in NAMES]
@nrp.MapRobotPublisher("a", nrp.Topic(TOPICS[0], String))
@nrp.MapRobotPublisher("b", nrp.Topic("/own/%s" % "x", String))
@nrp.Robot2Neuron()
def f(t, a, b):
    match RNG.randrange(3):
        case 0:
            a.send_message(String(json.dumps({"t": t})))
        case 1 | 2 as n:
            b.send_message(String("n" + str(n)))
        case _:
            pass
    assert re.match("x", "xyz"), "no " + "match"
""",
    "monitors groups": """\
@nrp.NeuronMonitor(nrp.brain.sensors[0:3], nrp.population_rate)
def m(t):
    return True
@nrp.MapVariable("k", initial_value=1)
@nrp.NeuronMonitor(nrp.brain.actors[1], nrp.leaky_integrator_exp)
def n(t, k):
    k.value *= 2
    return k.value % 3 == 1
""",
    "resolve nrange": """\
EACH = nrp.map_neurons(nrp.nrange(0, nrp.brain.sensors.size - 1), lambda i: nrp.brain.sensors[i])
@nrp.MapSpikeSource("a", EACH, nrp.dc_source)
@nrp.MapSpikeSink("b", nrp.resolve(lambda brain: brain.actors), nrp.population_rate)
@nrp.MapSpikeSink("c", nrp.brain.sensors[[0, 2]] + nrp.brain.actors[1:], nrp.spike_recorder)
@nrp.Robot2Neuron()
def f(t, a, b, c):
    a.amplitude = [0.01 * b.rate] * len(a)
    if c.spiked:
        a.amplitude = 0.0
""",
    "partial params": '''\
from functools import partial
@nrp.MapSpikeSink("a", nrp.brain.actors[0], nrp.leaky_integrator_alpha, **{"tau_m": 20.0})
@nrp.Neuron2Robot(robot_topic=nrp.Topic("/husky/cmd_vel", Twist))
def f(t: float, a) -> Twist:
    """Doc."""
    scale = partial(max, 0.0)
    message: Twist = Twist()
    message.linear.x = scale(a.voltage)
    setattr(message.angular, "z", 1.0)
    return message
OPTIONS = dict(weight=0.0001, delay=0.5)
@nrp.MapSpikeSource("go", nrp.brain.sensors[4], nrp.poisson, **OPTIONS)
@nrp.Robot2Neuron()
def g(t, go):
    go.rate = 3
''',
}


@pytest.fixture(params=STYLES.values(), ids=[name.replace(" ", "-") for name in STYLES])
def written(husky: Path, request: pytest.FixtureRequest) -> Path:
    """A file of transfer functions, with a module beside it."""
    (husky / "helpers.py").write_text(HELPERS)
    (husky / "own.py").write_text(HEAD + request.param)
    return husky / "own.py"


@pytest.mark.one_of(6)
def test_a_correct_file_yields_no_finding(husky: Path, written: Path) -> None:
    topics = ", ".join(f"{name}: std_msgs/{kind}" for name, kind in TOPICS.items())
    own = [f"transfer_functions=[{written}]", f"topics={{{topics}}}"]
    found = validate_file(husky / "experiment.yaml", own)
    assert [str(one) for one in found if one.level is not Level.NOTE] == []


def test_they_run(husky: Path, written: Path) -> None:
    network = load_network(husky / "brain.py", populations={"sensors": "0:5", "actors": "6:8"})
    for function in load_transfer_functions(written):
        rig = Rig(function, MockBrain(network))
        rig.run()
        rig.run()
