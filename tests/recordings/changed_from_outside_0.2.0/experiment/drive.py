import hbp_nrp_client.tf_framework as nrp
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import Float64


@nrp.MapRobotSubscriber("speed", nrp.Topic("/speed", Float64))
@nrp.MapRobotSubscriber("camera", nrp.Topic("/cart/camera", Image))
@nrp.MapSpikeSource("noise", nrp.brain.inputs, nrp.poisson, rate=200.0, weight=3.0)
@nrp.MapSpikeSink("rate", nrp.brain.outputs, nrp.population_rate)
@nrp.Neuron2Robot(nrp.Topic("/cart/cmd_vel", Twist))
def drive(t, speed, camera, noise, rate):
    noise.rate = 200.0 if camera.value is None else 100.0 + float(camera.value.data[0, 0, 0])
    forward = 0.2 if speed.value is None else speed.value.data
    return Twist(Vector3(forward, 0, 0), Vector3(0, 0, 0.01 * rate.rate))


@nrp.MapRobotSubscriber("joints", nrp.Topic("/arm/joint_states", JointState))
@nrp.MapVariable("seen", initial_value=0)
@nrp.Neuron2Robot(nrp.Topic("/arm/elbow/cmd_pos", Float64))
def reach(t, joints, seen):
    seen.value += 1
    return Float64(0.0 if joints.value is None else -joints.value.position[0])
