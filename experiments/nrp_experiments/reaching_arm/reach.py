"""Reach for one target after the other, and learn what the weight of the arm asks for in addition.

The command of a joint is the angle at which the hand would be at the target if the motors were strong, plus
the correction by the nuclei. The error of a joint drives the climbing fibres. Where a parallel fibre and a
climbing fibre are active together, their synapse is depressed; a parallel fibre alone strengthens it: M. Ito,
Annu. Rev. Neurosci. 12:85 (1989). The form of the rule is that of R. R. Carrillo et al., Biosystems 94:18
(2008).
"""

from math import acos, atan2, cos, exp, hypot, sin

import hbp_nrp_client.tf_framework as nrp
import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

COLUMNS, ROWS, CELLS = 5, 6, 5
LENGTH = 0.3  # m, of the upper arm and of the forearm
TARGETS = (0.50, 0.0), (0.40, 0.20), (0.32, -0.05), (0.44, -0.24)  # m ahead of and above the shoulder
EACH_S, JUDGED_S = 2.0, 0.5  # a reach, and its end in which the hand should be at the target

PLACES = np.array([(x, z) for x in np.linspace(0.25, 0.55, COLUMNS) for z in np.linspace(-0.3, 0.3, ROWS)])
WIDTH, HIGHEST_HZ = 0.08, 100.0  # m and Hz, of the granule cells' fields
CALM_HZ, ALARMED_HZ, LARGE = 1.0, 10.0, 0.1  # of a climbing fibre; at an error of LARGE rad it is alarmed

RAD_PER_HZ = 0.02 / CELLS  # correction for the difference of two groups of nuclei
DEPRESSION, HIGHEST, MEMORY_S = 2e-4, 0.2, 0.1  # nA per climbing spike and Hz of the parallel fibre; nA; s


def angles_at(target):
    """Return the angles of shoulder and elbow, down positive, with the elbow below the line to the target."""
    x, z = target
    bend = acos((x * x + z * z) / (2 * LENGTH * LENGTH) - 1)
    return atan2(-z, x) + bend / 2, -bend


def hand_at(shoulder, elbow):
    """Return the place of the hand, m ahead of and above the shoulder."""
    down = shoulder + elbow
    return LENGTH * (cos(shoulder) + cos(down)), -LENGTH * (sin(shoulder) + sin(down))


class Weights(nrp.CustomDevice):
    """The weights of a projection, as they are in the running brain."""

    def apply(self, neurons, brain, projection=""):
        self._brain, self._label = brain, projection
        (self.wiring,) = [one for one in brain.network.projections if one.label == projection]

    def set(self, weights):
        self._brain.set_weights(self._label, weights)


def group(population):
    """Return the selector of a group: shoulder down, shoulder up, elbow down, elbow up."""
    return lambda number: population[slice(CELLS * number, CELLS * (number + 1))]


@nrp.MapSpikeSource(
    "places", nrp.map_neurons(len(PLACES), lambda n: nrp.brain.granules[n]), nrp.poisson, weight=1.6
)
@nrp.MapRobotPublisher("shoulder", nrp.Topic("/arm/shoulder/cmd_pos", Float64))
@nrp.MapRobotPublisher("elbow", nrp.Topic("/arm/elbow/cmd_pos", Float64))
@nrp.MapSpikeSink("nuclei", nrp.map_neurons(4, group(nrp.brain.nuclei)), nrp.population_rate, tau_fall=200.0)
@nrp.Neuron2Robot()
def command(t, places, nuclei, shoulder, elbow):
    """Show the granule cells the target, and command the angles for it, corrected by the nuclei."""
    target = TARGETS[int(t / EACH_S) % len(TARGETS)]
    places.rate = HIGHEST_HZ * np.exp(-((PLACES - target) ** 2).sum(axis=1) / (2 * WIDTH**2))
    down, up, elbow_down, elbow_up = nuclei.rate
    wanted = angles_at(target)
    shoulder.send_message(Float64(wanted[0] + RAD_PER_HZ * (down - up)))
    elbow.send_message(Float64(wanted[1] + RAD_PER_HZ * (elbow_down - elbow_up)))


@nrp.MapRobotSubscriber("joints", nrp.Topic("/arm/joint_states", JointState))
@nrp.MapSpikeSource("errors", nrp.map_neurons(4, group(nrp.brain.olive)), nrp.poisson, weight=1.6)
@nrp.MapVariable("missed", initial_value=(0.0, 0))
@nrp.MapRobotPublisher("miss", nrp.Topic("/arm/miss", Float64))
@nrp.Robot2Neuron(triggers=["joints"])
def feel(t, joints, errors, missed, miss):
    """Drive the climbing fibres by the errors of the joints; publish the miss at the end of each reach."""
    state = joints.value
    angles = [state.position[state.name.index(joint)] for joint in ("shoulder", "elbow")]
    target = TARGETS[int(t / EACH_S) % len(TARGETS)]
    alarms = []
    for wanted, angle in zip(angles_at(target), angles, strict=True):
        alarms += [max(0.0, wanted - angle), max(0.0, angle - wanted)]
    errors.rate = [CALM_HZ + (ALARMED_HZ - CALM_HZ) * min(error / LARGE, 1.0) for error in alarms]
    left_s, (total, count) = EACH_S - t % EACH_S, missed.value
    if left_s <= JUDGED_S:
        x, z = hand_at(*angles)
        missed.value = total + hypot(x - target[0], z - target[1]), count + 1
    elif count:
        miss.send_message(Float64(total / count))
        missed.value = 0.0, 0


@nrp.MapSpikeSink("granules", nrp.brain.granules, nrp.spike_recorder, use_ids=False)
@nrp.MapSpikeSink("olive", nrp.brain.olive, nrp.spike_recorder, use_ids=False)
@nrp.MapSpikeSink("fibres", nrp.brain.purkinje, Weights(), projection="parallel fibres")
@nrp.MapVariable("weights", initial_value=None)
@nrp.MapVariable("trace", initial_value=None)
@nrp.MapVariable("before", initial_value=0.0)
@nrp.Neuron2Robot()
def learn(t, granules, olive, fibres, weights, trace, before):
    """Strengthen the synapses of active parallel fibres; depress those whose climbing fibre is active too."""
    wiring = fibres.wiring
    if weights.value is None:
        weights.value, trace.value = np.array(wiring.weight), np.zeros(len(PLACES))
    spikes = np.bincount(granules.times[:, 0].astype(int), minlength=len(PLACES))
    climbing = np.bincount(olive.times[:, 0].astype(int), minlength=4 * CELLS)
    step, before.value = t - before.value, t
    trace.value = trace.value * exp(-step / MEMORY_S) + spikes / MEMORY_S  # Hz
    stronger = DEPRESSION * CALM_HZ * spikes[wiring.pre_index]  # balances the depression when all is calm
    weaker = DEPRESSION * trace.value[wiring.pre_index] * climbing[wiring.post_index]
    weights.value = np.clip(weights.value + stronger - weaker, 0.0, HIGHEST)
    fibres.set(weights.value)
