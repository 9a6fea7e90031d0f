"""Each robot has two transfer functions: its camera excites its eyes, and its wheels drive it."""

import geometry_msgs.msg
import sensor_msgs.msg

import nrp_core.dsl as nrp


def excite(image, left, right):
    """Set the rates of the inputs of two eyes by the red in each half of an image."""
    red = nrp.tf_lib.detect_red(image)
    left.rate, right.rate = (1000.0 * min(1.0, 20.0 * part) for part in (red.left, red.right))


def twist(left, right):
    """Return the command for the rates of two wheels, Hz."""
    linear = geometry_msgs.msg.Vector3(0.004 * min(left.rate, right.rate), 0, 0)
    return geometry_msgs.msg.Twist(linear, geometry_msgs.msg.Vector3(0, 0, 0.02 * (right.rate - left.rate)))


@nrp.MapRobotSubscriber("camera", nrp.Topic("/cat/camera", sensor_msgs.msg.Image))
@nrp.MapSpikeSource("left", nrp.brain.cat.eyes[0], nrp.poisson, weight=1.0)
@nrp.MapSpikeSource("right", nrp.brain.cat.eyes[1], nrp.poisson, weight=1.0)
@nrp.Robot2Neuron()
def cat_sees(t, camera, left, right):
    excite(camera.value, left, right)


@nrp.MapSpikeSink("left", nrp.brain.cat.wheels[0], nrp.population_rate)
@nrp.MapSpikeSink("right", nrp.brain.cat.wheels[1], nrp.population_rate)
@nrp.Neuron2Robot(nrp.Topic("/cat/cmd_vel", geometry_msgs.msg.Twist))
def cat_moves(t, left, right):
    return twist(left, right)


@nrp.MapRobotSubscriber("camera", nrp.Topic("/dog/camera", sensor_msgs.msg.Image))
@nrp.MapSpikeSource("left", nrp.brain.dog.eyes[0], nrp.poisson, weight=1.0)
@nrp.MapSpikeSource("right", nrp.brain.dog.eyes[1], nrp.poisson, weight=1.0)
@nrp.Robot2Neuron()
def dog_sees(t, camera, left, right):
    excite(camera.value, left, right)


@nrp.MapSpikeSink("left", nrp.brain.dog.wheels[0], nrp.population_rate)
@nrp.MapSpikeSink("right", nrp.brain.dog.wheels[1], nrp.population_rate)
@nrp.Neuron2Robot(nrp.Topic("/dog/cmd_vel", geometry_msgs.msg.Twist))
def dog_moves(t, left, right):
    return twist(left, right)
