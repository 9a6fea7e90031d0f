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
@nrp.Robot2Neuron(triggers=["scan"])
def feel(t, scan, left, right, clearance):
    """Drive the feelers by the distances of obstacles, ahead most strongly; beams run from right to left."""
    beams = scan.value
    ranges = np.clip(beams.ranges, 0.0, beams.range_max)
    angles = beams.angle_min + beams.angle_increment * np.arange(len(ranges))
    felt = np.clip(1.0 - ranges / REACH, 0.0, 1.0) * np.cos(angles) ** 2
    aside = beams.angle_increment / 2  # a beam straight ahead is on neither side
    right.rate, left.rate = RATE * felt[angles < -aside].max(), RATE * felt[angles > aside].max()
    clearance.send_message(Float64(float(ranges.min())))


@nrp.MapSpikeSink("left", nrp.brain.wheels[:CELLS], nrp.population_rate, tau_fall=50.0)
@nrp.MapSpikeSink("right", nrp.brain.wheels[CELLS:], nrp.population_rate, tau_fall=50.0)
@nrp.Neuron2Robot(nrp.Topic("/pioneer/cmd_vel", Twist))
def drive(t, left, right):
    forward, turn = SPEED * (left.rate + right.rate) / 2, SPEED * (right.rate - left.rate) / TRACK
    return Twist(Vector3(forward), Vector3(0.0, 0.0, turn))
