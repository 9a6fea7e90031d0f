"""A small cerebellum: granule cells, Purkinje cells, climbing fibres from the olive, and deep nuclei.

Each granule cell fires for targets near one place. Parallel fibres lead from all granule cells to all
Purkinje cells; their weights are learned (see ``reach.py``). A climbing fibre makes its Purkinje cell fire
whenever it reports an error. Purkinje cells fire spontaneously and inhibit the nuclei, which fire
spontaneously as well and whose activity is the correction of the command. After D. Marr, J. Physiol. 202:437
(1969) and J. S. Albus, Math. Biosci. 10:25 (1971).

Olive, Purkinje cells and nuclei have four groups of ``CELLS``: shoulder down, shoulder up, elbow down, elbow
up. Units are PyNN's: mV, ms, nF, nA.
"""

import nrp_core.pynn as sim

COLUMNS, ROWS, CELLS, GROUPS = 5, 6, 5, 4

sim.setup(timestep=1.0)

cell = {"cm": 0.2, "tau_m": 10.0, "tau_refrac": 2.0, "tau_syn_E": 3.0, "tau_syn_I": 10.0}
granules = sim.Population(COLUMNS * ROWS, sim.IF_curr_exp(**cell), label="granules")
olive = sim.Population(GROUPS * CELLS, sim.IF_curr_exp(**cell), label="olive")
simple = sim.RandomDistribution("uniform", (0.36, 0.40))  # spontaneous, but not all at once
purkinje = sim.Population(GROUPS * CELLS, sim.IF_curr_exp(i_offset=simple, **cell), label="purkinje")
tonic = sim.RandomDistribution("uniform", (0.53, 0.57))
nuclei = sim.Population(GROUPS * CELLS, sim.IF_curr_exp(i_offset=tonic, **cell), label="nuclei")

sim.Projection(
    granules,
    purkinje,
    sim.AllToAllConnector(),
    sim.StaticSynapse(weight=0.1, delay=1.0),
    label="parallel fibres",
)
sim.Projection(
    olive,
    purkinje,
    sim.OneToOneConnector(),
    sim.StaticSynapse(weight=1.6, delay=1.0),
    label="climbing fibres",
)
for group in range(GROUPS):
    cells = slice(CELLS * group, CELLS * (group + 1))
    sim.Projection(
        purkinje[cells],
        nuclei[cells],
        sim.AllToAllConnector(),
        sim.StaticSynapse(weight=-0.04, delay=1.0),
        receptor_type="inhibitory",
    )
