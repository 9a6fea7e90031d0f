"""The scanner's sectors touch the inputs of the trained network; its last layer drives the wheels."""

import hbp_nrp_client.tf_framework as nrp
import numpy as np
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

from nrp_experiments.slalom_pioneer.sectors import SECTORS, sectors

CELLS = 5  # of each wheel
RATE = 600.0  # Hz of each feeler at contact, as in training
SPEED = 7.25e-4  # m/s of a wheel for each Hz of its cells, which fire at 120 Hz without obstacles
TRACK = 0.331  # m between the wheels


@nrp.MapRobotSubscriber("scan", nrp.Topic("/pioneer/scan", LaserScan))
@nrp.MapSpikeSource(
    "feelers", nrp.map_neurons(SECTORS, lambda i: nrp.brain.feelers[i]), nrp.poisson, weight=1.0
)
@nrp.MapRobotPublisher("clearance", nrp.Topic("/pioneer/clearance", Float64))
@nrp.Robot2Neuron(triggers=["scan"], vectorized=True)
def feel(t, scan, feelers, clearance):
    """Drive the inputs by the nearness of obstacles."""
    beams = scan.value  # arrays with a row for each copy of the experiment
    ranges = np.clip(beams.ranges, 0.0, beams.range_max[:, None], dtype=np.float32)
    angles = beams.angle_min[:, None] + beams.angle_increment[:, None] * np.arange(ranges.shape[1])
    feelers.rate = RATE * sectors(ranges, angles)
    clearance.send_message(Float64(ranges.min(axis=1)))


@nrp.MapSpikeSink("left", nrp.brain.wheels[:CELLS], nrp.population_rate, tau_fall=50.0)
@nrp.MapSpikeSink("right", nrp.brain.wheels[CELLS:], nrp.population_rate, tau_fall=50.0)
@nrp.Neuron2Robot(nrp.Topic("/pioneer/cmd_vel", Twist), vectorized=True)
def drive(t, left, right):
    on_left, on_right = left.rate, right.rate
    forward, turn = SPEED * (on_left + on_right) / 2, SPEED * (on_right - on_left) / TRACK
    return Twist(Vector3(forward), Vector3(0.0, 0.0, turn))
