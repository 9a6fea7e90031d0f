# Python 2 and the simulator by its PyNN name
import pyNN.nest as sim
print "building", 2, "cells"
sim.setup(timestep=0.1)
circuit = sim.Population(2, sim.IF_cond_alpha, {'cm': 0.025, 'tau_m': 10.0, 'v_rest': -60.5, 'v_thresh': -60.0, 'v_reset': -60.5})
sensors = circuit[0:1]
