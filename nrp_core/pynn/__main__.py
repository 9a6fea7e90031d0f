"""``python -m nrp_core.pynn SCRIPT [ARGUMENTS]`` runs a script that asks for its simulator by name.

The script finds a simulator ``pyNN.nrp``; PyNN's own examples run this way.
"""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import nrp_core.pynn
from nrp_core.brain.pynn.api import SIMULATOR_NAME


def main(arguments: list[str]) -> None:
    """Run a script with its arguments."""
    if not arguments or not Path(arguments[0]).is_file():
        sys.exit("usage: python -m nrp_core.pynn SCRIPT [ARGUMENTS]\nThe script's simulator is named 'nrp'.")
    sys.modules[f"pyNN.{SIMULATOR_NAME}"] = nrp_core.pynn
    sys.argv = arguments
    sys.path.insert(0, str(Path(arguments[0]).parent))
    runpy.run_path(arguments[0], run_name="__main__")


if __name__ == "__main__":
    main(sys.argv[1:])
