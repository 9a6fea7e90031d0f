import nest
import numpy as np
import logging
logger = logging.getLogger(__name__)

def create_brain():
    SENSORPARAMS = {'E_L': -60.5, 'V_m': -60.5, 'V_th': -60.0, 'V_reset': -60.5, 't_ref': 10.0, 'g_L': 2.5, 'C_m': 25., 'tau_syn_ex': 2.5, 'tau_syn_in': 2.5, 'E_ex': 0.0, 'E_in': -75.0}
    GO_ON_PARAMS = dict(SENSORPARAMS, V_th=-60.51, V_reset=-61.6)
    population = nest.Create('iaf_cond_alpha', 8)
    nest.SetStatus(population[0:5], SENSORPARAMS)
    nest.SetStatus(population[5:6], GO_ON_PARAMS)
    nest.SetStatus(population[6:8], SENSORPARAMS)
    syn = {'U': 1.0, 'tau_rec': 1.0, 'tau_fac': 1.0}
    nest.CopyModel('tsodyks2_synapse', 'syn', syn)
    nest.Connect([population[2]], [population[7]], {'rule': 'all_to_all'}, {'model': 'syn', 'weight': 0.15, 'delay': 0.1})
    nest.Connect(population[3:4], population[6:7], 'all_to_all', {'model': 'syn', 'weight': 0.15, 'delay': 0.1})
    nest.Connect(population[0:2], population[4:6], 'all_to_all', {'model': 'tsodyks_synapse', 'weight': -1.2, 'delay': 0.1, 'U': 1., 'tau_rec': 1., 'tau_fac': 1.})
    nest.Connect([population[4]], [population[7]], syn_spec={'model': 'syn', 'weight': .105, 'delay': 0.1})
    return population

circuit = create_brain()
first = circuit[0]
some = [circuit[1], circuit[3]]
