import geometry_msgs.msg
import hbp_nrp_client.tf_framework as nrp
import std_msgs.msg


@nrp.MapRobotSubscriber("speed", nrp.Topic("/speed", std_msgs.msg.Float64))
@nrp.MapSpikeSource("noise", nrp.brain.sensors, nrp.fixed_frequency, rate=100.0)
@nrp.MapSpikeSink("wheel", nrp.brain.actors[0], nrp.leaky_integrator_alpha)
@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive(t, speed, noise, wheel):
    forward = 0.0 if speed.value is None else speed.value.data
    return geometry_msgs.msg.Twist(geometry_msgs.msg.Vector3(forward, 0, 0))
