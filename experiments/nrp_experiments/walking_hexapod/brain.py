"""A central pattern generator for six legs: twelve half centres that inhibit each other.

Each leg has a half centre that swings it forward and one that pushes it back. Cells of both fire
spontaneously; the half centre that fires silences the other one of its leg. The silence does not last:
inhibitory synapses depress (they recover with ``tau_rec``), the silent one escapes, and the roles change,
about once a second. This is the half-centre oscillator of T. G. Brown (1911), with depressing synapses.

Swinging legs inhibit the swing of their neighbours: the legs before and behind them on the same side and the
one opposite. So neighbours take turns, and three legs always stand: the tripod gait of insects. The random
initial potentials determine which three begin.

Cells of leg ``i`` are ``[CELLS * i : CELLS * (i + 1)]`` in both populations; the order of legs is that of the
robot's file: left front, middle, rear, then right. Units are PyNN's: mV, ms, nF, nA.
"""

import nrp_core.pynn as sim

LEGS, CELLS = 6, 8
NEIGHBOURS = {0: (1, 3), 1: (0, 2, 4), 2: (1, 5), 3: (4, 0), 4: (3, 5, 1), 5: (4, 2)}

sim.setup(timestep=1.0)

CELL = sim.IF_curr_exp(
    cm=0.2, tau_m=20.0, tau_refrac=4.0, v_rest=-65.0, v_reset=-65.0, v_thresh=-50.0,
    tau_syn_E=5.0, tau_syn_I=10.0, i_offset=sim.RandomDistribution("uniform", (0.29, 0.41)),
)  # fmt: skip
spread = sim.RandomDistribution("uniform", (-65.0, -50.0))
swing = sim.Population(LEGS * CELLS, CELL, initial_values={"v": spread}, label="swing")
stance = sim.Population(LEGS * CELLS, CELL, initial_values={"v": spread}, label="stance")


def leg(population, i):
    """Return the cells of a leg."""
    return population[CELLS * i : CELLS * (i + 1)]


def inhibit(pre, post, weight):
    """Connect all cells to all others by depressing inhibitory synapses."""
    sim.Projection(
        pre,
        post,
        sim.AllToAllConnector(),
        sim.TsodyksMarkramSynapse(weight=-weight, delay=1.0, U=0.03, tau_rec=1000.0, tau_facil=0.0),
        receptor_type="inhibitory",
    )


for i, others in NEIGHBOURS.items():
    inhibit(leg(swing, i), leg(stance, i), weight=3.0)
    inhibit(leg(stance, i), leg(swing, i), weight=3.0)
    for j in others:
        inhibit(leg(swing, i), leg(swing, j), weight=1.5 / len(NEIGHBOURS[j]))
