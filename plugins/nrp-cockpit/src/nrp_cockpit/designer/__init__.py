"""The designer: transfer functions as boxes and wires. It uses the model of ``nrp_bibi``."""
