"""A source of noise, cells that it excites, and cells that these inhibit; units are PyNN's."""

import nrp_core.pynn as sim

sim.setup(timestep=1.0)

cell = {"cm": 0.25, "tau_m": 20.0, "tau_refrac": 3.0, "tau_syn_E": 5.0, "tau_syn_I": 5.0, "v_thresh": -55.0}
driven = sim.Population(10, sim.IF_curr_exp(**cell, i_offset=0.1), label="driven")
going = sim.RandomDistribution("uniform", (0.14, 0.2))  # not all at once
steady = sim.Population(10, sim.IF_curr_exp(**cell, i_offset=going), label="steady")
sim.Projection(
    driven,
    steady,
    sim.AllToAllConnector(),
    sim.StaticSynapse(weight=-0.005, delay=2.0),
    receptor_type="inhibitory",
)
