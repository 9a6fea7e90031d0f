import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64

from acme_lab.nose import Smell


@nrp.MapRobotSubscriber("smell", nrp.Topic("/cart/nose", Smell))
@nrp.Neuron2Robot(nrp.Topic("/cart/hinge", Float64))
def hinge(t, smell):
    if smell.value is None:
        return None
    return Float64(0.5 * smell.value.concentration)
