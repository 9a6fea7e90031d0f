"""Four groups of cells see in which direction an object is off centre; four others turn the head there.

Each cell of ``retina`` excites one of ``muscles`` enough to make it fire, and inhibits a cell of the
opposite muscle. Groups have ten cells each, in the order left, right, up, down.
Units are PyNN's: mV, ms, nF, nA.
"""

import nrp_core.pynn as sim

CELLS = 10
LEFT, RIGHT, UP, DOWN = (slice(CELLS * i, CELLS * (i + 1)) for i in range(4))

sim.setup(timestep=1.0)

cell = sim.IF_curr_exp(cm=0.2, tau_m=10.0, tau_refrac=2.0, tau_syn_E=2.0, tau_syn_I=10.0)
retina = sim.Population(4 * CELLS, cell, label="retina")
muscles = sim.Population(4 * CELLS, cell, label="muscles")

sim.Projection(
    retina, muscles, sim.OneToOneConnector(), sim.StaticSynapse(weight=6.0, delay=1.0), label="this way"
)
for way, opposite in ((LEFT, RIGHT), (RIGHT, LEFT), (UP, DOWN), (DOWN, UP)):
    sim.Projection(
        retina[way],
        muscles[opposite],
        sim.OneToOneConnector(),
        sim.StaticSynapse(weight=-2.0, delay=1.0),
        receptor_type="inhibitory",
        label="not that way",
    )
