"""A vehicle that avoids obstacles: one on a side speeds up that side's wheel and slows the other down.

Both wheels turn spontaneously, so without obstacles the robot drives straight on. The two groups of feelers
inhibit each other: of two obstacles ahead, the nearer one determines the turn. After V. Braitenberg,
"Vehicles" (1984), vehicle 2a. Groups are of ten cells. Units are PyNN's: mV, ms, nF, nA.

The six weights are parameters; a negative one inhibits. The experiment ``evolved`` has others.
"""

import nrp_core.pynn as sim

CELLS = 10
LEFT, RIGHT = slice(0, CELLS), slice(CELLS, 2 * CELLS)

left_to_left = sim.parameter("left_to_left", 0.03, unit="nA", doc="left feelers to the left wheel")
left_to_right = sim.parameter("left_to_right", -0.05, unit="nA", doc="left feelers to the right wheel")
left_to_other = sim.parameter("left_to_other", -1.0, unit="nA", doc="left feelers to the right ones")
right_to_right = sim.parameter("right_to_right", 0.03, unit="nA", doc="right feelers to the right wheel")
right_to_left = sim.parameter("right_to_left", -0.05, unit="nA", doc="right feelers to the left wheel")
right_to_other = sim.parameter("right_to_other", -1.0, unit="nA", doc="right feelers to the left ones")

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


connect(feelers[LEFT], wheels[LEFT], left_to_left)
connect(feelers[LEFT], wheels[RIGHT], left_to_right)
connect(feelers[LEFT], feelers[RIGHT], left_to_other)
connect(feelers[RIGHT], wheels[RIGHT], right_to_right)
connect(feelers[RIGHT], wheels[LEFT], right_to_left)
connect(feelers[RIGHT], feelers[LEFT], right_to_other)
