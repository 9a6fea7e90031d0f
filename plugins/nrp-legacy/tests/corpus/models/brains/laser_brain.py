import pyNN.nest as sim
from pyNN.random import RandomDistribution, NumpyRNG
import numpy as np

sim.setup(timestep=0.1, min_delay=0.1, max_delay=4.0, spike_precision="off_grid")
rng = NumpyRNG(seed=4242, parallel_safe=True)
cell = {'tau_m': 20.0, 'cm': 0.1, 'v_rest': -65.0, 'v_reset': -65.0, 'v_thresh': -55.0, 'tau_syn_E': 5.0, 'i_offset': 0.0}
inputs = sim.Population(10, cellclass=sim.IF_curr_exp, cellparams=cell, label='inputs')
outputs = sim.Population(2, sim.IF_curr_exp(**cell), structure=sim.Line(dx=10.0))
outputs.set(i_offset=RandomDistribution('uniform', [0.06, 0.07], rng=rng))
weights = RandomDistribution('normal', (0.3, 0.01), rng=rng)
near = sim.Projection(inputs, outputs, sim.FixedProbabilityConnector(0.9, rng=rng), sim.StaticSynapse(weight=weights, delay=1.0))
by_hand = sim.Projection(outputs, outputs, sim.FromListConnector([(0, 1, -0.05, 1.0), (1, 0, -0.05, 1.0)]), receptor_type='inhibitory')
ring = sim.Projection(inputs, inputs, sim.OneToOneConnector(), synapse_type=sim.STDPMechanism(
    timing_dependence=sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=0.01, A_minus=0.012),
    weight_dependence=sim.AdditiveWeightDependence(w_min=0, w_max=0.04), weight=0.01, delay=1.0))
stimulus = sim.Population(1, sim.SpikeSourceArray, {'spike_times': [float(t) for t in range(5, 900, 5)]})
sim.Projection(stimulus, outputs, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.1, delay=0.5))
step = sim.DCSource(amplitude=0.02, start=20.0, stop=80.0)
step.inject_into(inputs)
noise = sim.NoisyCurrentSource(mean=0.0, stdev=0.01, start=50.0, stop=450.0, dt=1.0)
outputs.inject(noise)
outputs.record(['spikes', 'v'])
circuit = sim.Assembly(inputs, outputs, label='circuit')
logger_time = sim.get_current_time()
