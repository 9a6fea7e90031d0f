# -*- coding: utf-8 -*-
"""
This file contains the setup of the neuronal network running the Husky experiment with neuronal image recognition
"""
# pragma: no cover

from hbp_nrp_cle.brainsim import simulator as sim
import numpy as np
import logging

logger = logging.getLogger(__name__)


def create_brain():
    """
    Initializes PyNN with the neuronal network that has to be simulated
    """
    SENSORPARAMS = {'v_rest': -60.5, 'cm': 0.025, 'tau_m': 10., 'tau_refrac': 10.0, 'tau_syn_E': 2.5, 'tau_syn_I': 2.5,
                    'e_rev_E': 0.0, 'e_rev_I': -75.0, 'v_thresh': -60.0, 'v_reset': -60.5}
    GO_ON_PARAMS = dict(SENSORPARAMS, v_thresh=-60.51, v_reset=-61.6)
    population = sim.Population(8, sim.IF_cond_alpha())
    population[0:5].set(**SENSORPARAMS)
    population[5:6].set(**GO_ON_PARAMS)
    population[6:8].set(**SENSORPARAMS)
    # Shared Synapse Parameters
    syn_params = {'U': 1.0, 'tau_rec': 1.0, 'tau_facil': 1.0}
    SYN = sim.TsodyksMarkramSynapse(weight=1.5e-4, delay=0.1, **syn_params)
    sim.Projection(presynaptic_population=population[2:3], postsynaptic_population=population[7:8],
                   connector=sim.AllToAllConnector(), synapse_type=SYN, receptor_type='excitatory')
    sim.Projection(population[3:4], population[6:7], sim.AllToAllConnector(), SYN, receptor_type='excitatory')
    INH = sim.TsodyksMarkramSynapse(weight=1.2e-3, delay=0.1, **syn_params)
    sim.Projection(population[0:2], population[4:6], sim.AllToAllConnector(), INH, receptor_type='inhibitory')
    sim.Projection(population[4:5], population[7:8], sim.AllToAllConnector(),
                   sim.TsodyksMarkramSynapse(weight=1.05e-4, delay=0.1, **syn_params), receptor_type='excitatory')
    sim.Projection(population[5:6], population[7:8], sim.AllToAllConnector(),
                   sim.TsodyksMarkramSynapse(weight=1.4e-4, delay=0.1, **syn_params), receptor_type='excitatory')
    sim.initialize(population, v=population.get('v_rest'))
    logger.debug("Circuit description: " + str(population.describe()))
    return population


circuit = create_brain()
