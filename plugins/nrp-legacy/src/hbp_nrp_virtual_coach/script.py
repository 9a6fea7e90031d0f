"""Run a script of the Virtual Coach with the modules that it had on the platform."""

from __future__ import annotations

import sys
import time
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from nrp_legacy.code import compiled_file
from nrp_legacy.files import Library
from nrp_legacy.shims.cv_bridge import cv_bridge_module
from nrp_legacy.shims.futurized import futurized_modules
from nrp_legacy.shims.libraries import libraries_of_old
from nrp_legacy.shims.matrices import transformations_module
from nrp_legacy.shims.modules import message_modules, module, service_modules
from nrp_legacy.shims.paths import Paths
from nrp_legacy.shims.rospy import rospy_module
from nrp_legacy.shims.transformations import tf_module

from hbp_nrp_virtual_coach.node import ScriptGraph, ScriptServices
from hbp_nrp_virtual_coach.simulation import Simulation
from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach
from nrp_core._support.scoped_import import Scope


def run_script(path: Path) -> ModuleType:
    """Run a script, in Python 2 or 3, as the main program, and return its module.

    ``rospy`` and the messages exist only in the script and the files beside it. They speak to the simulations
    that it launches.

    Raises:
        Exception: whatever the script raises.
    """
    graph = ScriptGraph()
    services = ScriptServices(graph)
    connected = [graph.begin, services.begin]
    Simulation.on_launch.extend(connected)
    try:
        return _scope(graph, services, path).run(path, name="__main__", code=compiled_file(path))
    finally:
        for begin in connected:
            Simulation.on_launch.remove(begin)


def _scope(graph: ScriptGraph, services: ScriptServices, path: Path) -> Scope:
    library = Library(path.parent)
    known = {
        **libraries_of_old(library.environment(), time.sleep, 0, sys.path, Paths(library)),
        **message_modules(),
        **service_modules(),
        **futurized_modules(),
        "rospy": rospy_module(graph, services),
        "cv_bridge": cv_bridge_module(),
        "tf": tf_module(),
        "tf.transformations": transformations_module(),
        **_newer_names(),
    }
    roots = {name.partition(".")[0] for name in known}
    return Scope(roots, known.get, (), None, compiled_file)


def _newer_names() -> dict[str, ModuleType]:
    """Return the modules of the Virtual Coach under their newer name, ``pynrp``, unless that is installed."""
    if find_spec("pynrp") is not None:
        return {}
    simulation = module("pynrp.simulation", Simulation=Simulation)
    coach = module("pynrp.virtual_coach", VirtualCoach=VirtualCoach, Simulation=Simulation)
    return {one.__name__: one for one in (simulation, coach)}
