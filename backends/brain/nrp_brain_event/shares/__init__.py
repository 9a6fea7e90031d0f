"""Laws by which a spike transmits a share of the weight, one module each.

:mod:`nrp_brain_event.synapse_laws` lists them, and says what a kernel gets.
"""
