from pyNN.connectors import Connector
from pyNN.random import RandomDistribution
import nest
import pyNN.nest as sim


class Pairs(Connector):
    def __init__(self, pairs):
        self.source, self.target = [p[0] for p in pairs], [p[1] for p in pairs]

    def connect(self, projection):
        nest.Connect([projection.pre.all_cells[i] for i in self.source], [projection.post.all_cells[j] for j in self.target],
                     'one_to_one', syn_spec=projection.nest_synapse_model)


sim.setup(timestep=0.1)
sim.nest.CopyModel('iaf_cond_alpha', 'eye', {'t_ref': 9.0, 'E_L': -60.5, 'V_th': -60.0, 'V_reset': -60.5, 'g_L': 2.5, 'C_m': 25.0})
circuit = sim.Population(4, sim.native_cell_type('eye')())
eyes, wheels = circuit[0:2], circuit[2:4]
weights = RandomDistribution('uniform', (0.02, 0.01))
synapse = sim.TsodyksMarkramSynapse(weight=weights, delay=1.0, U=1.0, tau_rec=0.0, tau_facil=0.0)
sim.Projection(eyes, wheels, Pairs([(0, 1), (1, 0)]), synapse, receptor_type='excitatory')
