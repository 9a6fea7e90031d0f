"""The designer: transfer functions as boxes and wires. Its model is the one of ``nrp_bibi``."""
