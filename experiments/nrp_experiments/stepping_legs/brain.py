"""The spinal cord of two legs: a pattern generator of four half centres, and motoneurons of twelve muscles.

The flexor and the extensor half centre of a leg inhibit each other, as do the flexor half centres of the two
legs, by depressing synapses: the silent one escapes, and the roles change, about once a second (T. G. Brown,
1911). A half centre excites the motoneurons of its three muscles. Afferents set the phase: Ia fibres of hip
flexors, which an extended hip stretches, excite the flexor half centre and so begin the swing (S. Grillner
and S. Rossignol, Brain Res. 146:269, 1978); Ib fibres of ankle extensors, which a loaded leg excites, excite
the extensor half centre and so maintain the stance (B. A. Conway et al., Exp. Brain Res. 68:643, 1987).

Populations are ordered by leg, left then right, and the motoneurons of a leg by muscle. Units are PyNN's: mV,
ms, nF, nA.
"""

from nrp_core import pynn as sim
from nrp_core.brain import MotoneuronPool

LEGS, CELLS, FIBRES, MOTONEURONS = 2, 20, 20, 20
FLEXORS = {"hip_flexor": 0.25, "knee_flexor": 0.22, "ankle_flexor": 0.2}
EXTENSORS = {"hip_extensor": 0.27, "knee_extensor": 0.22, "ankle_extensor": 0.22}
MUSCLES = (*FLEXORS, *EXTENSORS)

afferents = sim.parameter("afferents", 1.0, low=0, high=2, doc="factor of afferents' effect on half centres")

sim.setup(timestep=0.5)

CELL = {"cm": 0.2, "tau_m": 20.0, "tau_refrac": 4.0, "v_thresh": -50.0, "tau_syn_E": 5.0, "tau_syn_I": 10.0}
FIBRE = {"cm": 0.2, "tau_m": 10.0, "tau_refrac": 2.0, "v_thresh": -50.0, "tau_syn_E": 2.0}
tonic = sim.RandomDistribution("uniform", (0.3, 0.38))
spread = sim.RandomDistribution("uniform", (-60.0, -50.0))


def half_centres(label, first):
    """Return a population of one half centre of each leg; that of one leg is the first to fire."""
    cells = sim.Population(LEGS * CELLS, sim.IF_curr_exp(i_offset=tonic, **CELL), label=label)
    of(cells, CELLS, first).initialize(v=spread)
    return cells


def of(cells, size, number):
    """Return the cells of a leg or muscle."""
    return cells[size * number : size * (number + 1)]


flexors, extensors = half_centres("flexors", first=0), half_centres("extensors", first=1)
ia = sim.Population(LEGS * FIBRES, sim.IF_curr_exp(**FIBRE), label="ia")
ib = sim.Population(LEGS * FIBRES, sim.IF_curr_exp(**FIBRE), label="ib")
units = MotoneuronPool(MOTONEURONS, recruitment=4.0).parameters()
units["cm"] = units["cm"] * (LEGS * len(MUSCLES))
motoneurons = sim.Population(len(units["cm"]), sim.IF_curr_exp(**units), label="motoneurons")


def inhibit(source, target, weight):
    """Connect all cells to all others by depressing inhibitory synapses."""
    synapse = sim.TsodyksMarkramSynapse(
        weight=-weight / CELLS, delay=1.0, U=0.03, tau_rec=1500.0, tau_facil=0.0
    )
    sim.Projection(source, target, sim.AllToAllConnector(), synapse, receptor_type="inhibitory")


def excite(source, target, weight, share):
    """Connect cells with a probability."""
    synapse = sim.StaticSynapse(weight=weight, delay=1.0)
    sim.Projection(source, target, sim.FixedProbabilityConnector(share), synapse, receptor_type="excitatory")


for leg in range(LEGS):
    flexor, extensor = of(flexors, CELLS, leg), of(extensors, CELLS, leg)
    inhibit(flexor, extensor, 32.0)
    inhibit(extensor, flexor, 32.0)
    inhibit(flexor, of(flexors, CELLS, 1 - leg), 20.0)
    excite(of(ia, FIBRES, leg), flexor, 0.0375 * afferents, 1.0)
    excite(of(ib, FIBRES, leg), extensor, 0.1 * afferents, 1.0)
    for place, (muscle, weight) in enumerate({**FLEXORS, **EXTENSORS}.items()):
        pool = of(motoneurons, MOTONEURONS, len(MUSCLES) * leg + place)
        excite(flexor if muscle in FLEXORS else extensor, pool, weight, 0.8)
