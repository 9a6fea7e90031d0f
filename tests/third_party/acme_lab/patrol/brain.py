import pyNN.nest as sim

from acme_lab.networks import Ring

sim.setup(timestep=0.1)
source = sim.Population(4, sim.SpikeSourcePoisson(rate=200.0), label="source")
cells = sim.Population(4, sim.IF_curr_exp(), label="cells")
sim.Projection(source, cells, Ring(1), sim.AcmeDepression(weight=9.0, tau_D=50.0), label="ring")
