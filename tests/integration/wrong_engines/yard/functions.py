"""What the scanner sees drives the brain; the brain's rate drives the cart, in curves."""

import math

import hbp_nrp_client.tf_framework as nrp
import numpy as np
from geometry_msgs.msg import Twist, Vector3, WrenchStamped
from sensor_msgs.msg import Imu, LaserScan


@nrp.MapRobotSubscriber("scan", nrp.Topic("/cart/scan", LaserScan))
@nrp.MapSpikeSource("near", nrp.brain.driven, nrp.poisson, weight=0.1)
@nrp.Robot2Neuron(triggers=["scan"])
def feel(t, scan, near):
    near.rate = 1200.0 / (1.0 + float(np.minimum(scan.value.ranges, scan.value.range_max).min()))


@nrp.MapSpikeSink("rate", nrp.brain.steady, nrp.population_rate, tau_fall=50.0)
@nrp.Neuron2Robot(nrp.Topic("/cart/cmd_vel", Twist))
def drive(t, rate):
    return Twist(Vector3(0.2 + 0.002 * rate.rate), Vector3(0.0, 0.0, 0.8 * math.sin(4.0 * t)))


@nrp.MapRobotSubscriber("imu", nrp.Topic("/cart/imu", Imu))
@nrp.MapRobotSubscriber("weight", nrp.Topic("/stand/weight", WrenchStamped))
@nrp.MapSpikeSource("current", nrp.brain.steady, nrp.dc_source)
@nrp.Robot2Neuron(triggers=["imu", "weight"])
def carry(t, imu, weight, current):
    """Take some of the load to the brain, so that both sensors are used."""
    if imu.value is None or weight.value is None:
        return  # nothing has arrived yet
    current.amplitude = 1e-4 * (abs(weight.value.wrench.force.z) + imu.value.linear_acceleration.z)
