"""The transfer functions with the selectors and gains of the Neurorobotics Platform's own experiment."""

import geometry_msgs.msg
import hbp_nrp_client.tf_framework as nrp
import sensor_msgs.msg


@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", sensor_msgs.msg.Image))
@nrp.MapSpikeSource("red_left_eye", nrp.brain.sensors[slice(0, 3, 2)], nrp.poisson)
@nrp.MapSpikeSource("red_right_eye", nrp.brain.sensors[slice(1, 4, 2)], nrp.poisson)
@nrp.MapSpikeSource("green_blue_eye", nrp.brain.sensors[4], nrp.poisson)
@nrp.Robot2Neuron()
def eye_sensor_transmit(t, camera, red_left_eye, red_right_eye, green_blue_eye):
    image_results = nrp.tf_lib.detect_red(camera.value)
    red_left_eye.rate = 2000.0 * image_results.left
    red_right_eye.rate = 2000.0 * image_results.right
    green_blue_eye.rate = 75.0 * image_results.go_on


@nrp.MapSpikeSink("left_wheel_neuron", nrp.brain.actors[1], nrp.leaky_integrator_alpha)
@nrp.MapSpikeSink("right_wheel_neuron", nrp.brain.actors[2], nrp.leaky_integrator_alpha)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def linear_twist(t, left_wheel_neuron, right_wheel_neuron):
    left, right = left_wheel_neuron.voltage, right_wheel_neuron.voltage
    linear = geometry_msgs.msg.Vector3(20.0 * min(left, right), 0, 0)
    angular = geometry_msgs.msg.Vector3(0, 0, 100.0 * (right - left))
    return geometry_msgs.msg.Twist(linear=linear, angular=angular)
