"""``python -m nrp_core.pynn [OPTIONS] SCRIPT [ARGUMENTS]`` runs a script written for another simulator.

By default the script asks for its simulator by name, and finds ``pyNN.nrp``, as PyNN's own examples do; or it
imports a simulator of PyNN, such as ``pyNN.nest``: then this one takes its place and its time step, and a
note says so.
``--backend NAME`` and ``--option NAME=VALUE`` choose the brain backend, whatever the script's ``setup`` has.
With ``--as NAME`` an installed :mod:`runner <nrp_core.pynn.runners>` runs it.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from nrp_core.brain.backends import brains
from nrp_core.errors import ExperimentError, NrpError
from nrp_core.network.pynn.api import SIMULATOR_NAME
from nrp_core.network.pynn.dialects import Dialects
from nrp_core.pynn import new_simulator
from nrp_core.pynn.runners import RUNNERS, run_as_main
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
    parser.add_argument("--backend", metavar="NAME", help="the brain backend in which the network runs")
    parser.add_argument(
        "--option", dest="options", metavar="NAME=VALUE", action="append", default=[], type=_option,
        help="an option of the backend, such as resolution=0.1ms; repeatable",
    )  # fmt: skip
    given, script = script_arguments(parser, arguments)
    chosen = dict(given.options)
    if len(chosen) < len(given.options):
        parser.error("an --option is given twice, and takes one value")
    try:
        run = _run if given.simulator == SIMULATOR_NAME else RUNNERS.load(given.simulator)
        run(script, given.backend, chosen)
    except NrpError as error:
        sys.exit(f"error: {error}")


def _option(text: str) -> tuple[str, str]:
    name, _, value = text.partition("=")
    if not (name and value):
        raise argparse.ArgumentTypeError(f"an option is written NAME=VALUE, not '{text}'")
    return name, value


class _NotAsked(Dialects):
    """The modules of dialects for a script that was not started as one of theirs."""

    def module(self, name: str) -> ModuleType | None:
        dialect = self.dialect_with(name)
        if dialect is not None and dialect.module(name) is not None:
            raise ExperimentError(f"imports '{name}', so it is run with `--as {dialect.runner}`")
        return None


def _run(script: Path, backend: str | None, options: Mapping[str, str]) -> None:
    """Run a script as the main program; each simulator of PyNN that it imports is one of ours."""
    sim = new_simulator()
    if backend is not None:
        brains().provider(backend)
    vars(sim)["setup"] = _setup(sim.setup, backend, options)
    sim.setup()  # for a script that does not call it
    sys.modules[f"pyNN.{SIMULATOR_NAME}"] = sim
    asking = {name: import_module(name) for name in ("pyNN.utility", "pyNN.utility.script_tools")}
    replaced = sim.state.replaced.names.append
    try:
        run_as_main(script, sim, _NotAsked(sim), modules=asking, replaced=replaced)
    finally:
        sim.state.replaced.report()


def _setup(begin: Callable[..., int], backend: str | None, options: Mapping[str, str]) -> Callable[..., int]:
    """Return ``setup`` with a backend and options that take the place of those of a script."""

    def setup(*arguments: Any, **given: Any) -> int:
        if backend is not None:
            given = {**given, "backend": backend}
        if options:
            given = {**given, "options": {**(given.get("options") or {}), **options}}
        return begin(*arguments, **given)

    return setup


if __name__ == "__main__":
    main(sys.argv[1:])
