"""The wrong backends are modules of their own, which subclass each other and an example that ships."""

import sys
from pathlib import Path

from command_fixtures import nrp, nrp_process
from experiment_fixtures import _place

__all__ = ["_place", "nrp", "nrp_process"]

ROOT = Path(__file__).parents[3]
sys.path.append(str(Path(__file__).with_name("wrong")))
sys.path.append(str(ROOT / "plugins" / "nrp-brain-minimal" / "src"))
