"""A vehicle that avoids obstacles: one on a side speeds up that side's wheel and slows the other down.

Both wheels turn spontaneously, so without obstacles the robot drives straight on. The two groups of feelers
inhibit each other: of two obstacles ahead, the nearer one determines the turn. After V. Braitenberg,
"Vehicles" (1984), vehicle 2a. Groups are of ten cells. Units are PyNN's: mV, ms, nF, nA.
"""

import nrp_core.pynn as sim

CELLS = 10
LEFT, RIGHT = slice(0, CELLS), slice(CELLS, 2 * CELLS)

sim.setup(timestep=1.0)

cell = {"cm": 0.2, "tau_m": 10.0, "tau_refrac": 2.0, "tau_syn_E": 3.0, "tau_syn_I": 10.0}
feelers = sim.Population(2 * CELLS, sim.IF_curr_exp(**cell), label="feelers")
going = sim.RandomDistribution("uniform", (0.36, 0.40))  # cells that fire spontaneously, not all at once
wheels = sim.Population(2 * CELLS, sim.IF_curr_exp(i_offset=going, **cell), label="wheels")


def connect(pre, post, weight):
    """Connect all cells with all; a negative weight inhibits."""
    sim.Projection(
        pre,
        post,
        sim.AllToAllConnector(),
        sim.StaticSynapse(weight=weight, delay=1.0),
        receptor_type="excitatory" if weight > 0 else "inhibitory",
    )


for side, other in ((LEFT, RIGHT), (RIGHT, LEFT)):
    connect(feelers[side], wheels[side], 0.03)
    connect(feelers[side], wheels[other], -0.05)
    connect(feelers[side], feelers[other], -1.0)
