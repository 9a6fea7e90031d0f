"""Receptors of stretch drive the motoneurons, the voltages of muscles bend the body; the gait is measured."""

import hbp_nrp_client.tf_framework as nrp
import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

from nrp_experiments.bodies.worm import Worm

WORM, REST = Worm(), -60.0
BEHIND = 12  # segments whose stretch a neuron feels, fewer at the tail

proprioception = nrp.parameter("proprioception", 1.0, low=0, high=2, doc="gain of the receptors of stretch")
dorsal_from = nrp.parameter(
    "dorsal_from", [0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22], doc="first segment that each DB feels"
)
ventral_from = nrp.parameter(
    "ventral_from", [0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22], doc="first segment that each VB feels"
)


def fields(first):
    """Return the current for a full stretch of each segment, nA, shape ``(neurons, segments)``."""
    first, segment = np.array(first)[:, None], np.arange(WORM.segments)
    felt = (segment >= first) & (segment < first + BEHIND)
    return 0.65 * (0.4 + 0.04 * first) * np.sqrt(BEHIND / felt.sum(axis=1, keepdims=True)) * felt


DORSAL, VENTRAL = proprioception * fields(dorsal_from), proprioception * fields(ventral_from)
BODY = nrp.Topic("/worm/joint_states", JointState)


@nrp.MapRobotSubscriber("body", BODY)
@nrp.MapSpikeSource("DB", nrp.map_neurons(len(dorsal_from), lambda i: nrp.brain.DB[i]), nrp.dc_source)
@nrp.MapSpikeSource("VB", nrp.map_neurons(len(ventral_from), lambda i: nrp.brain.VB[i]), nrp.dc_source)
@nrp.Robot2Neuron()
def feel(t, body, DB, VB):
    """Each B neuron sums the stretch of its side over the half of the body behind it."""
    if body.value is not None:
        dorsal, ventral = WORM.stretch(np.array(body.value.position))
        DB.amplitude, VB.amplitude = DORSAL @ dorsal, VENTRAL @ ventral


@nrp.MapRobotSubscriber("body", BODY)
@nrp.MapSpikeSink("dorsal", nrp.brain.dorsal, nrp.voltage_recorder, dt=2.0)
@nrp.MapSpikeSink("ventral", nrp.brain.ventral, nrp.voltage_recorder, dt=2.0)
@nrp.MapRobotPublisher("torques", nrp.Topic("/worm/muscles/commands", Float64MultiArray))
@nrp.Neuron2Robot()
def pull(t, body, dorsal, ventral, torques):
    """A muscle is active as its voltage exceeds that at rest: fully with 10 mV."""
    if body.value is None or not len(dorsal.values):
        return
    active = [np.maximum(side.values[-1] - REST, 0.0) / 10.0 for side in (dorsal, ventral)]
    angles, speeds = np.array(body.value.position), np.array(body.value.velocity)
    torques.send_message(Float64MultiArray(data=WORM.torques(*active, angles, speeds).tolist()))


MIDDLE, TRUNK = WORM.segments // 2, slice(4, 20)
PLACES = (np.arange(WORM.segments) / WORM.segments)[TRUNK]


@nrp.MapRobotSubscriber("body", BODY)
@nrp.MapVariable("state", initial_value=(0.0, None, None, 0.0))
@nrp.MapRobotPublisher("frequency", nrp.Topic("/worm/frequency", Float64))
@nrp.MapRobotPublisher("wavelength", nrp.Topic("/worm/wavelength", Float64))
@nrp.Neuron2Robot()
def measure(t, body, state, frequency, wavelength):
    """Publish the frequency of the gait, Hz, and the length of its wave in body lengths, once a period.

    A period is from one rise of the middle hinge through 0 to the next. The wave is the slope of the phases
    of the hinges, each of its Fourier component with the period before.
    """
    if body.value is None:
        return
    angles = np.array(body.value.position)
    before, since, period, phasors = state.value
    if before < 0.0 <= angles[MIDDLE]:
        if since is not None:
            frequency.send_message(Float64(1.0 / (t - since)))
        if period is not None:
            slope = np.polyfit(PLACES, np.unwrap(np.angle(phasors[TRUNK])), 1)[0]
            wavelength.send_message(Float64(float(2.0 * np.pi / abs(slope))))
        since, period, phasors = t, since and t - since, 0.0
    if period is not None:
        phasors = phasors + angles * np.exp(-2j * np.pi * t / period)
    state.value = float(angles[MIDDLE]), since, period, phasors
