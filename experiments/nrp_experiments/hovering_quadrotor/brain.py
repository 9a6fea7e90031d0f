"""Four groups of cells encode height and vertical speed; two others raise and lower the thrust.

``below`` and ``falling`` excite ``lift`` and inhibit ``sink``, ``above`` and ``rising`` do the reverse, one
cell to one cell. A weight of 6 nA is enough to make a cell fire, so that the rates of the groups add up.
Units are PyNN's: mV, ms, nF, nA.
"""

import nrp_core.pynn as sim

CELLS = 40

sim.setup(timestep=1.0)

cell = sim.IF_curr_exp(cm=0.2, tau_m=10.0, tau_refrac=1.0, tau_syn_E=2.0, tau_syn_I=5.0)
below, above, falling, rising, lift, sink = (
    sim.Population(CELLS, cell, label=label)
    for label in ("below", "above", "falling", "rising", "lift", "sink")
)


def reach(sense, motor, weight, receptor):
    """Connect each cell of a sensory group with one of a motor group."""
    synapse = sim.StaticSynapse(weight=weight, delay=1.0)
    label = f"{sense.label} to {motor.label}"
    sim.Projection(sense, motor, sim.OneToOneConnector(), synapse, receptor_type=receptor, label=label)


reach(below, lift, 6.0, "excitatory")
reach(falling, lift, 6.0, "excitatory")
reach(above, sink, 6.0, "excitatory")
reach(rising, sink, 6.0, "excitatory")
reach(below, sink, -2.0, "inhibitory")
reach(falling, sink, -2.0, "inhibitory")
reach(above, lift, -2.0, "inhibitory")
reach(rising, lift, -2.0, "inhibitory")
