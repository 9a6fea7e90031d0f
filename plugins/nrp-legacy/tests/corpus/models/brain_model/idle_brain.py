# -*- coding: utf-8 -*-
"""
This file contains the setup of the neuronal network of an idle brain
"""
# pragma: no cover
__author__ = 'Nobody'

from hbp_nrp_cle.brainsim import simulator as sim
import numpy as np
import logging

logger = logging.getLogger(__name__)


def create_brain():
    """Initializes PyNN with the minimal neuronal network"""
    sim.setup(timestep=0.1, min_delay=0.1, max_delay=20.0, threads=1, rng_seeds=[1234])

    NEURONPARAMS = {'v_rest': -60.5, 'tau_m': 4.0, 'i_offset': 0.0, 'v_reset': -60.5, 'tau_refrac': 2.0,
                    'tau_syn_E': 10.0, 'e_rev_I': -75.0, 'e_rev_E': 0.0, 'tau_syn_I': 10.0, 'v_thresh': -60.4, 'cm': 0.025}
    SYNAPSE_PARAMS = {"weight": 0.5e-4, "delay": 20.0, 'U': 1.0, 'tau_rec': 0.0, 'tau_facil': 0.0}

    cell_class = sim.IF_cond_alpha(**NEURONPARAMS)
    synapse_type = sim.TsodyksMarkramSynapse(**SYNAPSE_PARAMS)
    connector = sim.AllToAllConnector()
    pop_a = sim.Population(size=1, cellclass=cell_class)
    pop_b = sim.Population(size=1, cellclass=cell_class)
    sim.Projection(presynaptic_population=pop_a, postsynaptic_population=pop_b, connector=connector,
                   synapse_type=synapse_type, receptor_type='excitatory')
    sim.initialize(pop_a, v=pop_a.get('v_rest'))
    return pop_a + pop_b

circuit = create_brain()
