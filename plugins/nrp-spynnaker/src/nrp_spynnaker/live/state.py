"""Runs a network step by step, with the live connections of its script.

At the beginning of a step callbacks may send spikes and set rates; at its end the spikes of the step are
passed to those that hear them. Spikes sent from there go out in the next step. A network that receives spikes
over UDP keeps to the real time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Event, Thread, current_thread
from typing import Any

import numpy as np

from nrp_core.brain import Brain, IntArray, SinkPort, SinkSpec, Spikes
from nrp_core.clock import MS_PER_S
from nrp_core.errors import LifecycleError
from nrp_core.network.changes import Rewirings
from nrp_core.pynn.running import DEFAULT_BACKEND, RunningState
from nrp_spynnaker.dialect.connections import Hub
from nrp_spynnaker.live.clock import SimulatedClock
from nrp_spynnaker.live.packets import Sockets

# mypy: disable-error-code="misc"


@dataclass(frozen=True, slots=True)
class Listener(SinkSpec):
    """Keeps the spikes of the last window."""

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> ListenerPort:
        return ListenerPort(neurons, n_neurons, name)


class ListenerPort(SinkPort):
    """An active :class:`Listener`."""

    passing = True

    def __init__(self, neurons: IntArray, n_neurons: int, name: str) -> None:
        super().__init__(neurons, n_neurons, name)
        self.reset()

    def take(self) -> IntArray:
        """Return the cells that fired, as indices, in the order of their spikes."""
        cells: IntArray = np.concatenate([np.empty(0, np.int64), *self._cells]) - self.neurons[0]
        self.reset()
        return cells

    def _absorb(self, spikes: Spikes, until_ms: float) -> None:
        self._cells.append(spikes.neurons)

    def reset(self) -> None:
        self._cells: list[IntArray] = []

    def save(self) -> object:
        return None

    def restore(self, saved: Any) -> None:
        self.reset()


class LiveState(RunningState):
    """A network that runs with live connections.

    Args:
        hub: the connections.
        clock: the time in which their callbacks sleep.
        waits: whether a run without an end returns when it is stopped, as on the machine.
    """

    def __init__(self, hub: Hub, clock: SimulatedClock, *, waits: bool = False) -> None:
        self.hub, self._clock, self._waits = hub, clock, waits
        hub.is_run = True
        self._sockets: Sockets | None = None
        self._ports: dict[str, ListenerPort] = {}
        self._forever: Thread | None = None
        self._stop, self._ended = Event(), Event()
        self._waiting, self._script = False, current_thread()
        self._failure: BaseException | None = None
        self._first = True
        self._fed = set[str]()
        self.after_reset: list[Callable[[], None]] = []
        self.before_run: list[Callable[[float], None]] = []
        super().__init__()

    def clear(self) -> None:
        self.after_reset.clear()
        self.before_run.clear()
        super().clear()

    def rewirings_onto(self, population: Any) -> list[Rewirings]:
        """Return which synapses onto a population formed and vanished, for each projection of that kind."""
        if self.brain is None:
            return []
        onto = [one for one in self.projections if one.post is population and one in self._shares]
        rewired = [one for one in onto if getattr(one.synapse_type, "rewiring", None) is not None]
        return [self.brain.read_rewirings(label) for one in rewired for label, _ in self._shares.of(one)]

    def reset(self) -> None:
        super().reset()
        changes, self.after_reset = self.after_reset, []
        for change in changes:
            change()

    def run_until(self, t_ms: float) -> None:
        if self._forever is not None and current_thread() is not self._forever:
            raise LifecycleError("run: the network runs already; call external_devices.request_stop() first")
        self._extend(t_ms)
        self.hub.resume()
        if not self.hub.is_used and not self.hub.ports:
            super().run_until(t_ms)
            return
        with self._stopping_programs_on_failure():
            self._begin(t_ms)
            assert self._sockets is not None
            if not self.hub.is_used and not self._sockets.has_programs:
                super().run_until(t_ms)
                return
            self._step_until(t_ms, _Pace(self.t) if self._sockets.listens else None)
            self._end()

    def run_forever(self) -> None:
        """Run in real time in a thread of its own until :meth:`stop`; return when it has begun, or ended.

        A thread that the script started for this run waits for its end.
        """
        if self._forever is not None:
            raise LifecycleError("run_forever: the network runs already")
        self.hub.resume()
        self._stop.clear()
        with self._stopping_programs_on_failure():
            self._begin(float("inf"))
            self._step_until(self.t + self.dt)
        self._ended.clear()
        self._forever = Thread(target=self._run_in_real_time, name="run_forever", daemon=True)
        self._forever.start()
        if self._waits or current_thread() is not self._script:
            self._waiting = True
            try:
                self._ended.wait()  # an interrupt of join() would let later ones return at once
            except KeyboardInterrupt:  # the script continues with the existing data
                self._stop.set()
                self._ended.wait()
            self._waiting = False
            self.stop()

    def stop(self) -> None:
        """Stop a network that runs forever; raise the exception of a callback."""
        self._stop.set()
        if self._waiting:  # the thread that waits does the rest
            forever = self._forever if current_thread() is self._script else None
            if forever is not None:
                forever.join()
            return
        if self._forever is not None and self._forever is not current_thread():
            self._forever.join()
            self._forever = None
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure

    def end(self) -> None:
        """Release the brain, and warn of injectors without a sender."""
        has_programs = self._sockets is not None and self._sockets.has_programs
        if self._longest_ms > 0.0 and not has_programs:
            known = {*self.hub.inputs, *self._fed}
            known.update(label for one in self.hub.connections for label in one.send_labels)
            self.warn(
                f"no spike was sent into '{label}': it has no port, and no connection has it in send_labels"
                for label in sorted(self.hub.injectors.keys() - known)
            )
        super().end()
        self.hub.end()

    def close(self) -> None:
        self.stop()
        self._clock.close()
        self._close_sockets()
        self._first = True
        if self.brain is not None:
            for recorder in self.recorders:
                recorder.keep()
        super().close()

    def _close_sockets(self) -> None:
        if self._sockets is not None:
            self._sockets.close()
            self._sockets = None

    def _run_in_real_time(self) -> None:
        try:
            with self._stopping_programs_on_failure():
                pace = _Pace(self.t)
                while not self._stop.is_set():
                    self._step_until(self.t + self.dt)
                    self._stop.wait(pace.ahead_s(self.t))
                self._end()
        except BaseException as error:  # noqa: BLE001 - raised in the thread of the script
            self._failure = error
        finally:
            self._ended.set()

    def _open(self) -> Brain:
        own = [one.label for one in self.populations if hasattr(one.celltype, "equations")]
        if own:
            self.warn([
                f"the cells of '{own[0]}' are given as equations, which the emulated machine does not have: "
                f"the network runs in '{DEFAULT_BACKEND}', in floating point"
            ])  # fmt: skip
            self._backend, self._options = DEFAULT_BACKEND, {}
        brain = super()._open()
        self._ports = {
            label: brain.add_sink(Listener(), _ids(population), name=f"live/{label}")
            for label, population in self.hub.live_outputs.items()
        }
        return brain

    def _begin(self, until_ms: float) -> None:
        self._require_network()
        self.hub.require_labels()
        if self.brain is None:
            self._open()
            self._close_sockets()
        if self._sockets is None:
            self._sockets = Sockets(self.hub)
        self._sockets.begin(self.dt, until_ms - self.t)
        first, self._first = self._first, False
        run_time_ms = until_ms - self.t
        if first:
            for label, callback in self._callbacks("init"):
                callback(label, self._size(label), run_time_ms, self.dt)
        self._clock.advance(self.t)
        for event in ("start", "start_resume") if first else ("start_resume",):
            self._call(event)

    def _end(self) -> None:
        self._call("pause_stop")
        assert self._sockets is not None
        self._sockets.end()

    @contextmanager
    def _stopping_programs_on_failure(self) -> Iterator[None]:
        try:
            yield
        except BaseException:  # an interrupt too: the programs would wait for more spikes
            if self._sockets is not None:
                self._sockets.end()
            raise

    def _call(self, event: str) -> None:
        """Call callbacks, each in a thread of its own, in which it may sleep."""
        for connection in list(self.hub.connections):
            for label, callback in connection.callbacks[event]:
                self._clock.begin(callback, label, connection)

    def _callbacks(self, event: str) -> list[tuple[str, Any]]:
        return [found for connection in self.hub.connections for found in connection.callbacks[event]]

    def _size(self, label: str) -> int:
        known = {**self.hub.live_outputs, **self.hub.injectors, **self.hub.controlled}
        return int(known[label].size)

    def _extend(self, t_ms: float) -> None:
        for extend in self.before_run:
            extend(t_ms)

    def _step_until(self, t_ms: float, pace: _Pace | None = None) -> None:
        self._extend(t_ms)
        last = round(t_ms / self.dt)
        for step in range(round(self.t / self.dt) + 1, last + 1):
            self._clock.advance(self.t)
            self._send()
            super().run_until(step * self.dt)
            self._pass_on(step)
            if pace is not None:
                time.sleep(pace.ahead_s(self.t))

    def _send(self) -> None:
        brain = self.brain
        assert brain is not None
        assert self._sockets is not None
        if self._sockets.listens:
            self.hub.sent.extend(self._sockets.received())
        while self.hub.sent:
            label, cells = self.hub.sent.popleft()
            population = self.hub.injectors[label]
            self._fed.add(label)
            name = brain.network.label_of(int(population.first_id))[0]
            each, counts = np.unique(cells, return_counts=True)
            brain.set_spike_times(name, [[self.t] * int(n) for n in counts], each)
        while self.hub.rates:
            label, cells, rates = self.hub.rates.popleft()
            ids = int(self.hub.controlled[label].first_id) + np.array(cells)
            brain.set_parameters(ids, {"rate": np.array(rates)})

    def _pass_on(self, step: int) -> None:
        fired = {label: port.take().tolist() for label, port in self._ports.items()}
        assert self._sockets is not None
        for label, cells in fired.items():
            self._sockets.send(label, step, cells)
        for connection in list(self.hub.connections):
            for label, callback, with_time in connection.receivers:
                if fired.get(label):
                    callback(label, step, fired[label]) if with_time else callback(label, fired[label])


class _Pace:
    """Keeps a run to the real time.

    Args:
        began_ms: the simulated time now.
    """

    def __init__(self, began_ms: float) -> None:
        self._began_s, self._began_ms = time.monotonic(), began_ms

    def ahead_s(self, now_ms: float) -> float:
        """Return the time by which the simulation is ahead; 0 if it is behind."""
        real_s = time.monotonic() - self._began_s
        return max(0.0, (now_ms - self._began_ms) / MS_PER_S - real_s)


def _ids(population: Any) -> IntArray:
    first = int(population.first_id)
    return np.arange(first, first + population.size)
