import hbp_nrp_client.tf_framework as nrp
from geometry_msgs.msg import Twist, Vector3


@nrp.MapSpikeSink("wheel", nrp.brain.outputs, nrp.leaky_integrator_alpha)
@nrp.Neuron2Robot(nrp.Topic("/cart/cmd_vel", Twist))
def drive(t, wheel):
    return Twist(Vector3(0.5 + wheel.voltage, 0, 0), Vector3(0, 0, 0.1))
