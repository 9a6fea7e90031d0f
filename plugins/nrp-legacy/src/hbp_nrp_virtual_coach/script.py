"""Run a script of the Virtual Coach with the modules that it had on the platform.

Its ``rospy`` is connected to each simulation that it launches in turn.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from nrp_legacy.code import Source, compiled_file, ignore_note
from nrp_legacy.files import Library
from nrp_legacy.maker import ShimmedMaker
from nrp_legacy.shims.graph import Attendant, Graph
from nrp_legacy.shims.libraries import futurized_modules, old_libraries
from nrp_legacy.shims.modules import cv_bridge_module, message_modules, module, service_modules
from nrp_legacy.shims.paths import Paths
from nrp_legacy.shims.rospy import rospy_module
from nrp_legacy.shims.services import ServiceException, Services
from nrp_legacy.shims.transformations import tf_module, transformations_module
from nrp_legacy.topics import find_alias

from hbp_nrp_virtual_coach.simulation import Simulation
from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach
from nrp_core.experiment import Run, RunObserver
from nrp_core.scripts import Scope

T = TypeVar("T")

_POLL_S = 0.001


class ScriptGraph(Graph, RunObserver[Run]):
    """The topics and the time of the simulation that was launched last, for the threads of a script.

    Callbacks are called in the thread of the run, before the functions of a step. Subscriptions and
    parameters outlive a simulation, as they outlived it in ROS.
    """

    def __init__(self) -> None:
        super().__init__()
        self._thread: int | None = None
        self._last_ns = 0

    def begin(self, run: Run) -> None:
        """Connect to a run, in its thread."""
        self.renew()
        super().begin(run)
        self._thread = threading.get_ident()
        if isinstance(run.experiment.maker, ShimmedMaker):
            run.experiment.maker.names.graph.parameters = self.parameters
        run.observers.append(self)

    def closing(self, run: Run) -> None:
        """Keep the time of the run that ends."""
        if self._run is run:
            self._last_ns, self._run, self._thread = run.loop.now_ns, None, None

    @property
    def now_ns(self) -> int:
        """Simulated time, ns; after a simulation that at its end, 0 before the first one."""
        run = self._run
        return self._last_ns if run is None else run.loop.now_ns

    @property
    def can_wait(self) -> bool:
        """Whether this thread can wait for the run: any thread except the one that runs it."""
        return self._thread != threading.get_ident()

    def wait_until(self, t_ns: int) -> None:
        """Wait for a simulated time, or until the simulation ends."""
        if self.can_wait:
            time.sleep(_POLL_S)
            while self._run is not None and self.now_ns < t_ns:
                time.sleep(_POLL_S)

    def glance(self) -> int:
        """Return the simulated time, ns, after a moment that leaves the run time."""
        if self.can_wait:
            time.sleep(_POLL_S)
        return self.now_ns

    def between_steps(self, call: Callable[[], T], otherwise: T) -> T:
        """Make a call in the thread of the run, between two steps; without a run return another value."""
        run = self._run
        return otherwise if run is None else run.loop.between_steps(call)

    def declare(self, topic: str, kind: type) -> None:
        served = find_alias(topic, kind, self.world)
        if served is not None:
            self.world.add_alias(topic, served)
        super().declare(topic, kind)

    def forget(self, listener: Attendant) -> None:
        forget = super().forget
        self.between_steps(lambda: forget(listener), None)

    def publish(self, topic: str, kind: type, message: Any) -> None:
        publish = super().publish
        self.between_steps(lambda: publish(topic, kind, message), None)


class ScriptServices(Services):
    """Calls of a script, each made between two steps; the simulation can call the script's services."""

    def __init__(self, graph: ScriptGraph) -> None:
        super().__init__(graph)
        self._script = graph

    def begin(self, run: Run) -> None:
        """Connect to a run, in its thread."""
        self.beyond = {}
        if isinstance(run.experiment.maker, ShimmedMaker):
            services = run.experiment.maker.names.services
            self.beyond, services.beyond = services.served, self.served

    def call(self, name: str, *values: Any, kind: Any = None, **fields: Any) -> Any:
        call = super().call
        answer = self._script.between_steps(lambda: call(name, *values, kind=kind, **fields), None)
        if answer is None:
            raise ServiceException(f"service {name} is available only while a simulation is open")
        return answer


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
    newer = _newer_names()
    sys.modules.update(newer)  # also for modules beyond the folder of the script
    try:
        code = Source(_code_of(path), path).compiled(ignore_note)
        return _scope(graph, services, path, newer).run(path, name="__main__", code=code)
    finally:
        for name in newer:
            sys.modules.pop(name, None)
        for begin in connected:
            Simulation.on_launch.remove(begin)


def _code_of(path: Path) -> str:
    """Return the code of a script; of a notebook that of its cells, without commands of IPython."""
    text = Source.of_file(path).text
    if path.suffix != ".ipynb":
        return text
    cells = ("".join(one["source"]) for one in json.loads(text)["cells"] if one["cell_type"] == "code")
    return "\n".join("" if line[:1] in ("%", "!") else line for cell in cells for line in cell.split("\n"))


def _scope(
    graph: ScriptGraph, services: ScriptServices, path: Path, newer: Mapping[str, ModuleType]
) -> Scope:
    library = Library(path.parent)
    known = {
        **old_libraries(library.environment(), time.sleep, 0, sys.path, Paths(library)),
        **message_modules(),
        **service_modules(),
        **futurized_modules(),
        "rospy": rospy_module(graph, services),
        "cv_bridge": cv_bridge_module(),
        "tf": tf_module(),
        "tf.transformations": transformations_module(),
        **newer,
    }
    roots = {name.partition(".")[0] for name in known}
    return Scope(roots, known.get, (), None, compiled_file)


def _newer_names() -> dict[str, ModuleType]:
    """Return the modules of the Virtual Coach under their newer name, ``pynrp``, unless that is installed."""
    if find_spec("pynrp") is not None:
        return {}
    simulation = module("pynrp.simulation", Simulation=Simulation)
    coach = module("pynrp.virtual_coach", VirtualCoach=VirtualCoach, Simulation=Simulation)
    package = module("pynrp", simulation=simulation, virtual_coach=coach)
    return {one.__name__: one for one in (package, simulation, coach)}
