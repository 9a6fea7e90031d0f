import nrp_core.pynn as sim

sim.setup(timestep=0.5)
inputs = sim.Population(4, sim.IF_curr_exp(tau_m=10.0), label="inputs")
outputs = sim.Population(2, sim.IF_cond_exp(i_offset=0.9), label="outputs")
sim.Projection(
    inputs,
    outputs,
    sim.AllToAllConnector(),
    sim.StaticSynapse(weight=sim.RandomDistribution("uniform", (0.005, 0.02)), delay=1.0),
    label="forward",
)
