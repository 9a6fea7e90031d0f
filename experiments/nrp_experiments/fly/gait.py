"""From descending cells to joints: a clock of steps with six legs, and the proboscis.

DNp09 sets how often the legs step, DNa02 shortens the steps on its side, MDN reverses them. Three legs stand
while three swing: front and hind legs of one side together with the middle leg of the other.
"""

from math import cos, pi, sin

import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64

steps = nrp.parameter("steps", 10.0, unit="Hz", low=0, high=20, doc="steps a second at full drive")
stride = nrp.parameter("stride", 0.25, unit="rad", low=0, high=0.6, doc="half the angle of a step")
lift = nrp.parameter("lift", 0.3, unit="rad", low=0, high=1, doc="angle by which a leg is lifted")

FULL_HZ = 60.0  # rate of a descending cell at full drive
STILL = 0.1  # share of the full drive below which the legs stand
TAU_MS = 60.0
LEGS = [(place, side) for side in ("left", "right") for place in ("front", "middle", "hind")]
TRIPOD = {("front", "left"), ("hind", "left"), ("middle", "right")}
EXTENDED = 1.5


def share(device):
    """Return the rate of a cell as a share of the full drive."""
    return min(device.rate / FULL_HZ, 1.0)


@nrp.MapSpikeSink("left", nrp.brain.DNp09_left, nrp.population_rate, tau_fall=TAU_MS)
@nrp.MapSpikeSink("right", nrp.brain.DNp09_right, nrp.population_rate, tau_fall=TAU_MS)
@nrp.MapSpikeSink("turn_left", nrp.brain.DNa02_left, nrp.population_rate, tau_fall=TAU_MS)
@nrp.MapSpikeSink("turn_right", nrp.brain.DNa02_right, nrp.population_rate, tau_fall=TAU_MS)
@nrp.MapSpikeSink("back", nrp.brain.MDN[0], nrp.population_rate, tau_fall=TAU_MS)
@nrp.MapVariable("before", initial_value=0.0)
@nrp.MapVariable("phase", initial_value=0.0, scope=nrp.GLOBAL)
@nrp.MapVariable("reach", initial_value=(0.0, 0.0), scope=nrp.GLOBAL)
@nrp.Neuron2Robot(nrp.Topic("/fly/drive", Float64))
def pace(t, left, right, turn_left, turn_right, back, before, phase, reach):
    drive = max((share(left) + share(right)) / 2, share(back))
    if drive < STILL:
        drive = 0.0
    direction = -1.0 if share(back) > max(share(left), share(right)) else 1.0
    phase.value += 2 * pi * steps * drive * (t - before.value)
    before.value = t
    turn = share(turn_left) - share(turn_right)
    walks = direction if drive else 0.0
    reach.value = (walks * min(1.0, 1.0 - turn), walks * min(1.0, 1.0 + turn))
    return Float64(direction * drive)


def named(name):
    """Give each leg's function a unique name."""

    def name_it(function):
        function.__name__ = name
        return function

    return name_it


def stepping(place, side):
    """Add the function of a leg."""
    path = f"/fly/{place}_{side}"
    on_right, offset = side == "right", 0.0 if (place, side) in TRIPOD else pi

    @nrp.MapVariable("phase", scope=nrp.GLOBAL)
    @nrp.MapVariable("reach", scope=nrp.GLOBAL)
    @nrp.MapRobotPublisher("swing", nrp.Topic(f"{path}_coxa_yaw/cmd_pos", Float64))
    @nrp.MapRobotPublisher("femur", nrp.Topic(f"{path}_femur_pitch/cmd_pos", Float64))
    @nrp.Neuron2Robot()
    @named(f"step_{place}_{side}")
    def step(t, phase, reach, swing, femur):
        angle, length = phase.value + offset, reach.value[on_right]
        swing.send_message(Float64(-stride * length * cos(angle)))
        femur.send_message(Float64(lift * abs(length) * max(0.0, sin(angle))))


for leg in LEGS:
    stepping(*leg)


@nrp.MapSpikeSink("left", nrp.brain.MN9_left, nrp.population_rate, tau_fall=TAU_MS)
@nrp.MapSpikeSink("right", nrp.brain.MN9_right, nrp.population_rate, tau_fall=TAU_MS)
@nrp.MapRobotPublisher("proboscis", nrp.Topic("/fly/proboscis/cmd_pos", Float64))
@nrp.Neuron2Robot()
def eat(t, left, right, proboscis):
    proboscis.send_message(Float64(EXTENDED * (share(left) + share(right)) / 2))
