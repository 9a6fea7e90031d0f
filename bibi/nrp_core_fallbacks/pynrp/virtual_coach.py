"""The Virtual Coach under its newer name.

``pynrp`` here has no ``__init__.py``: Python prefers an installed ``pynrp``, which has one, wherever it is.
"""

from hbp_nrp_virtual_coach.simulation import Simulation as Simulation
from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach as VirtualCoach
