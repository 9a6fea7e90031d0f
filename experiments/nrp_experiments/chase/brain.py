"""A brain that drives to what its eyes see.

::

    eyes     0, 1   red in the left, right half of the image
    search   0      fires without input: turns to the left; silent while an eye fires
    wheels   0, 1   the left, the right wheel

Each eye drives both wheels, the one of the other side more, so the robot turns to the red and drives there.
"""

import nrp_core.pynn as sim

sim.setup(timestep=1.0, min_delay=1.0)

cell = sim.IF_curr_exp(
    cm=0.25,
    tau_m=10.0,
    tau_refrac=2.0,
    v_rest=-65.0,
    v_reset=-65.0,
    v_thresh=-50.0,
    tau_syn_E=5.0,
    tau_syn_I=5.0,
)
eyes = sim.Population(2, cell, label="eyes")
search = sim.Population(1, cell, label="search")
search.set(i_offset=0.5)
wheels = sim.Population(2, cell, label="wheels")


def connect(pre, post, weight, receptor_type="excitatory"):
    """Connect each cell in ``pre`` to each in ``post``."""
    synapse = sim.StaticSynapse(weight=weight, delay=2.0)
    sim.Projection(pre, post, sim.AllToAllConnector(), synapse, receptor_type=receptor_type)


connect(eyes[0:1], wheels[1:2], 1.6)
connect(eyes[1:2], wheels[0:1], 1.6)
connect(eyes, wheels, 1.0)
connect(eyes, search, -2.0, receptor_type="inhibitory")
connect(search, wheels[1:2], 1.6)
