"""Bodies to build experiments with: a two-wheeler, a six-legged walker, a camera head.

========================  ============================================================================
``pioneer.sdf``           two driven wheels, a caster and a laser scanner
``hexapod.sdf``           six legs of four joints; made by :mod:`nrp_experiments.bodies.hexapod`
``fly.sdf``               a fly of true size; made by :mod:`nrp_experiments.bodies.fly`
``pan_tilt.sdf``          a camera that pans and tilts
========================  ============================================================================
"""

from importlib.resources import files
from pathlib import Path

FOLDER = Path(str(files(__name__)))
"""The folder of the files."""
