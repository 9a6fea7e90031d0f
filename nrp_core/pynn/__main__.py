"""``python -m nrp_core.pynn [--as NAME] SCRIPT [ARGUMENTS]`` runs a script written for another simulator.

By default the script asks for its simulator by name, and finds ``pyNN.nrp``; PyNN's own examples run so.
With ``--as spinnaker`` it is a script of sPyNNaker, which imports ``pyNN.spiNNaker`` or ``spynnaker.pyNN``;
it runs on the emulated machine, and nothing of it stays in ``sys.modules``.
"""

from __future__ import annotations

import argparse
import runpy
import sys
from pathlib import Path

import nrp_core.pynn
from nrp_core.brain.pynn.api import SIMULATOR_NAME
from nrp_core.errors import NrpError

_SIMULATORS = (SIMULATOR_NAME, "spinnaker")


def main(arguments: list[str]) -> None:
    """Run a script with its arguments."""
    parser = argparse.ArgumentParser(
        "python -m nrp_core.pynn", description="Run a PyNN script on the brain backends of nrp-core."
    )
    parser.add_argument(
        "--as", dest="simulator", choices=_SIMULATORS, default=SIMULATOR_NAME,
        help="the simulator that the script is written for: nrp, which it names on its command line, or "
        "spinnaker, which it imports",
    )  # fmt: skip
    parser.add_argument("script", metavar="SCRIPT")
    parser.add_argument("arguments", metavar="ARGUMENTS", nargs=argparse.REMAINDER)
    given = parser.parse_args(arguments)
    script = Path(given.script)
    if not script.is_file():
        parser.error(f"there is no file {given.script}")
    sys.argv = [given.script, *given.arguments]
    if given.simulator == SIMULATOR_NAME:
        sys.modules[f"pyNN.{SIMULATOR_NAME}"] = nrp_core.pynn
        sys.path.insert(0, str(script.parent))
        runpy.run_path(given.script, run_name="__main__")
        return
    from nrp_core.pynn.spynnaker import run_script

    try:
        run_script(script.resolve())
    except NrpError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main(sys.argv[1:])
