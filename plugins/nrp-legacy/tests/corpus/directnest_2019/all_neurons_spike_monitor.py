# Imported Python Transfer Function
import hbp_nrp_cle.tf_framework as nrp
# This transfer function automatically wires all neuron spikes to the monitor
@nrp.NeuronMonitor(nrp.brain.record, nrp.spike_recorder)
def all_neurons_spike_monitor(t):
    return True
