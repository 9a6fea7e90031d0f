"""PyNN 0.7 and Python 2, with parameters in a file beside it."""
import pyNN.nest as sim
import pylab
from pyNN.random import RandomDistribution, NumpyRNG
from lab import sizes

print "building", sizes.N
sim.setup(timestep=0.1, min_delay=0.1, max_delay=4.0)
half = sizes.N / 2
circuit = sim.Population(sizes.N, sim.IF_cond_exp, {'tau_m': 10.}, "cells")
circuit.set('tau_refrac', 2.0)
circuit.set({'v_thresh': -50.0})
circuit.rset('cm', RandomDistribution('uniform', [0.9, 1.0], rng=NumpyRNG(1)))
circuit.randomInit(RandomDistribution('uniform', [-66., -64.]))
sensors, actors = circuit[0:half], circuit[half:sizes.N]
static = sim.Projection(sensors, actors, sim.AllToAllConnector(weights=0.001, delays=1.0), target='excitatory')
static.setWeights(0.02)
learning = sim.STDPMechanism(
    timing_dependence=sim.SpikePairRule(tau_plus=20., tau_minus=20.),
    weight_dependence=sim.AdditiveWeightDependence(w_min=0, w_max=0.02, A_plus=0.01, A_minus=0.012))
plastic = sim.Projection(sensors, actors, sim.OneToOneConnector(weights=0.01, delays=1.),
                         synapse_dynamics=sim.SynapseDynamics(slow=learning), rng=NumpyRNG(3))
circuit.record()
circuit.record_v()
gains = {'left': 2.0, 'right': [1, 2, 3]}
