"""The camera's image drives the retina; the muscles' activity moves pan and tilt."""

from math import hypot

import hbp_nrp_client.tf_framework as nrp
from sensor_msgs.msg import Image
from std_msgs.msg import Float64

CELLS = 10
RED = (0, 30, 30), (0, 255, 255)  # HSV in OpenCV's ranges
RATE = 200.0  # Hz of each retina cell when the object is at the image's edge
SPEED = 4.0  # rad/s of the head when all cells of a muscle fire at that rate
OUT_OF_SIGHT = 9.0


def group(population):
    """Return the selector of a group of cells: left, right, up, down."""
    return lambda number: population[slice(CELLS * number, CELLS * (number + 1))]


@nrp.MapRobotSubscriber("camera", nrp.Topic("/pan_tilt/eye/image_raw", Image))
@nrp.MapSpikeSource("sides", nrp.map_neurons(4, group(nrp.brain.retina)), nrp.poisson, weight=6.0)
@nrp.MapRobotPublisher("error", nrp.Topic("/gaze/error", Float64))
@nrp.Robot2Neuron(triggers=["camera"])
def see(t, camera, sides, error):
    """Drive the retina by the object's offset from the image centre; 1 is half the image width."""
    image = camera.value
    centre = nrp.tf_lib.find_centroid_hsv(image, *RED)
    if centre is None:
        sides.rate = 0.0
        error.send_message(Float64(OUT_OF_SIGHT))
        return
    half = image.width / 2
    left, up = 1.0 - (centre[0] + 0.5) / half, (image.height / 2 - centre[1] - 0.5) / half
    sides.rate = [RATE * max(0.0, offset) for offset in (left, -left, up, -up)]
    error.send_message(Float64(hypot(left, up)))


@nrp.MapSpikeSink("pulls", nrp.map_neurons(4, group(nrp.brain.muscles)), nrp.population_rate)
@nrp.MapVariable("pan", initial_value=0.0)
@nrp.MapVariable("tilt", initial_value=0.0)
@nrp.MapVariable("before", initial_value=0.0)
@nrp.MapRobotPublisher("to_pan", nrp.Topic("/pan_tilt/pan/cmd_pos", Float64))
@nrp.MapRobotPublisher("to_tilt", nrp.Topic("/pan_tilt/tilt/cmd_pos", Float64))
@nrp.Neuron2Robot()
def turn(t, pulls, pan, tilt, before, to_pan, to_tilt):
    """Turn at a speed proportional to the difference of opposite muscles."""
    left, right, up, down = (rate / (RATE * CELLS) for rate in pulls.rate)
    step, before.value = SPEED * (t - before.value), t
    pan.value += step * (left - right)
    tilt.value += step * (down - up)
    to_pan.send_message(Float64(pan.value))
    to_tilt.send_message(Float64(tilt.value))
