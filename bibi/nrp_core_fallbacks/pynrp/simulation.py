"""A simulation under its newer name."""

from hbp_nrp_virtual_coach.simulation import Simulation as Simulation
