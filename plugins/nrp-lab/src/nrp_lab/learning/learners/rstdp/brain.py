"""Places excite actors through weights that learn from reward; the actors of an action inhibit all others."""

from itertools import permutations

import nrp_core.pynn as sim

observed = sim.parameter("observed", 2, low=1, high=3, doc="number of observed quantities")
actions = sim.parameter("actions", 2, low=2, doc="number of actions")
tau_c = sim.parameter("tau_c", 100.0, unit="ms", doc="decay of the eligibility")

ACTORS = 6  # for each action
PLACES = {1: 13, 2: 7**2, 3: 4**3}[observed]

sim.setup(timestep=0.1)
places = sim.Population(PLACES, sim.IF_curr_delta(tau_refrac=1.0), label="places")
actors = sim.Population(ACTORS * actions, sim.IF_curr_delta(tau_m=10.0), label="actors")
rule = sim.STDPMechanism(
    timing_dependence=sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=0.02, A_minus=0.0),
    weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=1.0),
    weight=1.0,  # mV
    delay=1.0,
)
sim.Projection(places, actors, sim.AllToAllConnector(), rule, label="policy")
silent = sim.Population(1, sim.SpikeSourceArray(spike_times=[]), label="silent")
dopamine = sim.Neuromodulation(weight=1.0, tau_c=tau_c, tau_d=20.0, w_min=0.0, w_max=2.0)
sim.Projection(silent, actors, sim.AllToAllConnector(), dopamine, receptor_type="reward")
groups = [actors[ACTORS * action : ACTORS * (action + 1)] for action in range(actions)]
for winner, other in permutations(groups, 2):
    synapse = sim.StaticSynapse(weight=-3.0, delay=1.0)
    sim.Projection(winner, other, sim.AllToAllConnector(), synapse, receptor_type="inhibitory")
