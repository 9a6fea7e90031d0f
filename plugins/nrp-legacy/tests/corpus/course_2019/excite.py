import rospy
from rospy_tutorials.msg import Floats


@nrp.MapRobotPublisher("levels", Topic("/course/levels", Floats))
@nrp.MapSpikeSource("noise", nrp.brain.actors, nrp.poisson, weight=0.05, rate=0.0)
@nrp.Robot2Neuron()
def excite(t, noise, levels):
    from hbp_nrp_cle.brainsim import simulator as sim
    assert sim.nest.GetKernelStatus()['resolution'] > 0
    rospy.set_param('answer', rospy.get_param('trial', 0) + 3)
    levels.send_message([t] + [2.0])
    noise.rate = 1000.0 if t > 1.0 else 0.0
