"""Synapse laws, one module each; :mod:`nrp_core.brain.network.synapses.laws` lists them."""
