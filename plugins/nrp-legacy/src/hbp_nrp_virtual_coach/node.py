"""What ``rospy`` of a script is connected to: the simulations that it launches, one after another."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, TypeVar

from nrp_legacy.aliases import find_alias
from nrp_legacy.maker import ShimmedMaker
from nrp_legacy.shims.graph import Attendant, Graph
from nrp_legacy.shims.services import ServiceException, Services

from nrp_core.experiment.running.run import Run

T = TypeVar("T")

_POLL_S = 0.001


class ScriptGraph(Graph):
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
        run.on_close.append(lambda: self._end(run))

    def _end(self, run: Run) -> None:
        if self._run is run:
            self._last_ns, self._run, self._thread = run.loop.now_ns, None, None

    @property
    def now_ns(self) -> int:
        """Simulated time, ns; after a simulation that at its end, 0 before the first one."""
        run = self._run
        return self._last_ns if run is None else run.loop.now_ns

    @property
    def can_wait(self) -> bool:
        """Whether this thread can wait for the run, as all can but the one that runs it."""
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
    """Calls of a script, each made between two steps; the simulation can call what the script serves."""

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
