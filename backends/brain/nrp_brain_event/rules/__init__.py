"""Rules by which spikes change weights, one module each; :mod:`nrp_brain_event.synapse_laws` lists them.

A module of a rule has two compiled functions, ``on_source(rule, synapse, t)`` and ``on_target(rule, synapse,
t)``: they update the weight and the traces of a synapse for a spike of its source or of its target that it
processes at t (ms).
"""
