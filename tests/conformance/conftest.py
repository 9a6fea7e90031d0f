"""The wrong backends are modules of their own, which subclass each other."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).with_name("wrong")))
