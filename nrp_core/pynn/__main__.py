"""``python -m nrp_core.pynn [--as NAME] SCRIPT [ARGUMENTS]`` runs a script written for another simulator.

By default the script asks for its simulator by name, and finds ``pyNN.nrp``, as PyNN's own examples do; or it
imports a simulator of PyNN, such as ``pyNN.nest``: then this one takes its place, and a note says so. With
``--as NAME`` an installed :mod:`runner <nrp_core.pynn.runners>` runs it.
"""

from __future__ import annotations

import argparse
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import nrp_core.pynn
from nrp_core.brain.files.script import scope_of
from nrp_core.brain.pynn.api import SIMULATOR_NAME
from nrp_core.brain.pynn.dialects import Dialects
from nrp_core.errors import ExperimentError, NetworkError, NrpError
from nrp_core.pynn.runners import RUNNERS
from nrp_core.scripts import script_arguments


def main(arguments: list[str]) -> None:
    """Run a script with its arguments."""
    parser = argparse.ArgumentParser(
        "python -m nrp_core.pynn", description="Run a PyNN script on the brain backends of nrp-core."
    )
    added = "".join(f", or {one.name} ({one.distribution}), which it imports" for one in RUNNERS.providers())
    parser.add_argument(
        "--as", dest="simulator", metavar="NAME", default=SIMULATOR_NAME,
        help=f"the simulator that the script is written for: {SIMULATOR_NAME}, which it names on its command "
        f"line{added}",
    )  # fmt: skip
    given, script = script_arguments(parser, arguments)
    try:
        if given.simulator == SIMULATOR_NAME:
            _run(script)
        else:
            RUNNERS.load(given.simulator)(script)
    except NrpError as error:
        sys.exit(f"error: {error}")


class _NotAsked(Dialects):
    """The modules of dialects for a script that was not started as one of theirs."""

    def module(self, name: str) -> ModuleType | None:
        dialect = self.dialect_with(name)
        if dialect is not None and dialect.module(name) is not None:
            raise ExperimentError(f"imports '{name}', so it is run with `--as {dialect.runner}`")
        return None


def _run(script: Path) -> None:
    """Run a script as the main program; each simulator of PyNN that it imports is this one."""
    sim = nrp_core.pynn
    sys.modules[f"pyNN.{SIMULATOR_NAME}"] = sim
    sys.path.insert(0, str(script.parent))
    asking = {name: import_module(name) for name in ("pyNN.utility", "pyNN.utility.script_tools")}
    scope = scope_of(sim, modules=asking, dialect=_NotAsked(sim), replaced=_tell)
    try:
        scope.run(script, name="__main__")
    except NrpError as error:
        raise scope.located(error, NetworkError, script) from error


def _tell(simulator: str) -> None:
    print(f"note: {simulator} is nrp_core.pynn here, which runs the network in nrp-core", file=sys.stderr)


if __name__ == "__main__":
    main(sys.argv[1:])
