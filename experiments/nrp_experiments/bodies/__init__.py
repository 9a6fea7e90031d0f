"""Bodies to build experiments with: a two-wheeler, a six-legged walker, a camera head.

========================  ============================================================================
``pioneer.sdf``           two driven wheels, a caster and a laser scanner
``hexapod.sdf``           six legs of four joints; made by :mod:`nrp_experiments.bodies.hexapod`
``fly.sdf``               a fly of true size; made by :mod:`nrp_experiments.bodies.fly`
``pan_tilt.sdf``          a camera that pans and tilts
``muscle_arm.sdf``        an arm with a pair of muscles at each of its two joints
``legs.sdf``              two legs with six muscles each, on a boom
========================  ============================================================================
"""

from importlib.resources import files
from pathlib import Path

FOLDER = Path(str(files(__name__)))
"""The folder of the files."""
