import nrp_core.pynn as sim

sim.setup(timestep=0.1)
circuit = sim.Population(4, sim.IF_curr_exp(), label="circuit")
