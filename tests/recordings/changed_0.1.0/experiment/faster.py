import geometry_msgs.msg
import hbp_nrp_client.tf_framework as nrp
import std_msgs.msg


@nrp.MapRobotSubscriber("speed", nrp.Topic("/speed", std_msgs.msg.Float64))
@nrp.MapSpikeSink("wheel", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive(t, speed, wheel):
    return geometry_msgs.msg.Twist(geometry_msgs.msg.Vector3(2.0 * speed.value.data, 0, 0), geometry_msgs.msg.Vector3(0, 0, 0.1))
