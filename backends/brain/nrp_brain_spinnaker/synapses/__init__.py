"""The synapses of each law on the machine; :mod:`nrp_brain_spinnaker.synapses.laws` lists them."""
