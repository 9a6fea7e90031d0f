"""The scanner's beams touch the feelers; the wheels' cells drive the wheels."""

import hbp_nrp_client.tf_framework as nrp
import numpy as np
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

CELLS = 10
REACH = 1.1  # m, the range of the feelers
RATE = 250.0  # Hz of each feeler at contact
SPEED = 7.5e-4  # m/s of a wheel for each Hz of its cells, which fire at 58 Hz spontaneously
TRACK = 0.331  # m between the wheels


@nrp.MapRobotSubscriber("scan", nrp.Topic("/pioneer/scan", LaserScan))
@nrp.MapSpikeSource("left", nrp.brain.feelers[:CELLS], nrp.poisson, weight=6.0)
@nrp.MapSpikeSource("right", nrp.brain.feelers[CELLS:], nrp.poisson, weight=6.0)
@nrp.MapRobotPublisher("clearance", nrp.Topic("/pioneer/clearance", Float64))
@nrp.Robot2Neuron(triggers=["scan"], vectorized=True)
def feel(t, scan, left, right, clearance):
    """Drive the feelers by the distances of obstacles, ahead most strongly; beams run from right to left."""
    beams = scan.value  # arrays with a row for each copy of the experiment
    ranges = np.clip(beams.ranges, 0.0, beams.range_max[:, None], dtype=np.float32)
    step = beams.angle_increment[:, None]
    angles = beams.angle_min[:, None] + step * np.arange(ranges.shape[1])
    felt = np.clip(1.0 - ranges / REACH, 0.0, 1.0) * np.cos(angles) ** 2
    aside = step / 2  # a beam straight ahead is on neither side
    right.rate = RATE * np.where(angles < -aside, felt, 0.0).max(axis=1)
    left.rate = RATE * np.where(angles > aside, felt, 0.0).max(axis=1)
    clearance.send_message(Float64(ranges.min(axis=1)))


@nrp.MapSpikeSink("left", nrp.brain.wheels[:CELLS], nrp.population_rate, tau_fall=50.0)
@nrp.MapSpikeSink("right", nrp.brain.wheels[CELLS:], nrp.population_rate, tau_fall=50.0)
@nrp.Neuron2Robot(nrp.Topic("/pioneer/cmd_vel", Twist), vectorized=True)
def drive(t, left, right):
    on_left, on_right = left.rate, right.rate
    forward, turn = SPEED * (on_left + on_right) / 2, SPEED * (on_right - on_left) / TRACK
    return Twist(Vector3(forward), Vector3(0.0, 0.0, turn))
