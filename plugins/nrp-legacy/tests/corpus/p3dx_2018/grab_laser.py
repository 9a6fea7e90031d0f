import numpy as np
import sensor_msgs.msg
import hbp_nrp_cle.tf_framework as nrp
from hbp_nrp_cle.robotsim.RobotInterface import Topic
N_SECTORS = 10


def sectors(ranges):
    """Shared by all transfer functions."""
    return [np.min(part) for part in np.array_split(np.array(ranges), N_SECTORS)]


@nrp.MapRobotSubscriber("laser", Topic('/robot/p3dx/laser/scan', sensor_msgs.msg.LaserScan))
@nrp.MapSpikeSource("near", nrp.map_neurons(range(0, 10), lambda i: nrp.brain.sensors[i]), nrp.dc_source, amplitude=0.0)
@nrp.Robot2Neuron()
def grab_laser(t, laser, near):
    if laser.value is None:
        return
    near.amplitude = [0.5 / max(0.1, d) for d in sectors(laser.value.ranges)]
