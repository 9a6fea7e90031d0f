"""Place cells encode observations, actor cells choose actions, and dopamine evaluates these.

Dopamine is the error of temporal-difference learning (Schultz, Dayan and Montague 1997, Science 275:1593):
the reward, plus the rewards that are expected now, less those that were expected before. Expectations are
a sum over the places, and learned with the same error (Sutton and Barto 2018, Reinforcement Learning,
section 12.2). Between episodes the weights from each place are shifted to their initial mean, so that
actions compete.
"""

import hbp_nrp_client.tf_framework as nrp
import numpy as np
from std_msgs.msg import Bool, Float64, Float64MultiArray, Int32

OBSERVED = nrp.parameter("observed", 2, low=1, high=3, doc="number of observed quantities")
ACTIONS = nrp.parameter("actions", 2, low=2, doc="number of actions")
GAIN = nrp.parameter("gain", 0.2, low=0, doc="dopamine for an error of 1")
DISCOUNT = nrp.parameter("discount", 0.9, low=0, high=1, doc="of a reward, for each step that it is away")
MEMORY = nrp.parameter("memory", 0.8, low=0, high=1, doc="of the expectation for places, for each step")
RATE = nrp.parameter("rate", 0.2, low=0, doc="at which expectations change")
NOISE_HZ = nrp.parameter("noise", 200.0, unit="Hz", low=0, doc="spikes into each actor, by which it explores")

BINS = {1: 13, 2: 7, 3: 4}[OBSERVED]
ACTORS, SPIKES, STEP_MS = 6, 20, 40.0  # for each action; of all places in a step
INITIAL, HIGHEST = 1.0, 2.0  # mV, of weights

AXIS = np.linspace(-1.0, 1.0, BINS)
CENTRES = np.stack(np.meshgrid(*[AXIS] * OBSERVED, indexing="ij"), axis=-1).reshape(-1, OBSERVED)
WIDTH = 0.6 * (AXIS[1] - AXIS[0])


def activity(observation):
    """Return the share of each place in the spikes of a step."""
    near = np.exp(-0.5 * ((CENTRES - observation) ** 2).sum(axis=1) / WIDTH**2)
    return near / near.sum()


@nrp.MapRobotSubscriber("observation", nrp.Topic("/task/observation", Float64MultiArray))
@nrp.MapSpikeSource("eyes", nrp.brain.places, nrp.injector, weight=20.0)
@nrp.MapSpikeSource("noise", nrp.brain.actors, nrp.poisson, weight=3.0)
@nrp.Robot2Neuron()
def see(t, observation, eyes, noise):
    """Divide the spikes of a step among the places."""
    seen = np.array(observation.value.data)
    noise.rate = NOISE_HZ if seen.size else 0.0
    if seen.size:
        places = np.searchsorted(np.cumsum(activity(seen)), (np.arange(SPIKES) + 0.5) / SPIKES)
        order = np.arange(SPIKES) * 7 % SPIKES  # neighbours do not fire one after the other
        eyes.inject_spikes(places, 1000.0 * t + (order + 0.5) * STEP_MS / SPIKES)


@nrp.MapRobotSubscriber("observation", nrp.Topic("/task/observation", Float64MultiArray))
@nrp.MapRobotSubscriber("reward", nrp.Topic("/task/reward", Float64))
@nrp.MapRobotSubscriber("failed", nrp.Topic("/task/failed", Bool))
@nrp.MapRobotSubscriber("learning", nrp.Topic("/task/learning", Bool))
@nrp.MapReward("dopamine", nrp.brain.projection("policy"))
@nrp.MapWeights("policy", nrp.brain.projection("policy"))
@nrp.MapVariable("expected", initial_value=np.zeros(len(CENTRES)))
@nrp.MapVariable("trace", initial_value=np.zeros(len(CENTRES)))
@nrp.MapVariable("before", initial_value=None)
@nrp.Robot2Neuron()
def learn(t, observation, reward, failed, learning, dopamine, policy, expected, trace, before):
    """Compare the reward with the expected one."""
    policy.plastic = learning.value.data
    if not learning.value.data:
        return
    seen, last = np.array(observation.value.data), before.value
    now = activity(seen) if seen.size else None
    before.value = now
    if last is None:
        return
    follows = 0.0 if now is None else DISCOUNT * (expected.value @ now)
    if now is not None or failed.value.data:  # what follows the time limit is not known
        error = reward.value.data + follows - expected.value @ last
        trace.value = DISCOUNT * MEMORY * trace.value + last
        expected.value = expected.value + RATE * error * trace.value
        dopamine.value = GAIN * error
    if now is None:
        trace.value = np.zeros(len(CENTRES))
        weights = policy.values.reshape(len(CENTRES), -1)
        policy.values = np.clip(weights + INITIAL - weights.mean(axis=1, keepdims=True), 0.0, HIGHEST).ravel()


@nrp.MapSpikeSink(
    "actors",
    nrp.map_neurons(ACTIONS, lambda action: nrp.brain.actors[ACTORS * action : ACTORS * (action + 1)]),
    nrp.population_rate,
    tau_rise=1.0,
    tau_fall=15.0,
)
@nrp.MapVariable("chosen", initial_value=0)
@nrp.Neuron2Robot(nrp.Topic("/task/action", Int32))
def choose(t, actors, chosen):
    """Choose the action whose actors fire most."""
    rates = np.array(actors.rate)
    if rates.any():
        chosen.value = int(rates.argmax())
    return Int32(chosen.value)
