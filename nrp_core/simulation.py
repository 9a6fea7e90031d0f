"""The common base of brains and worlds: a clock that only moves forward, and a life cycle.

The public methods are final and check the contract once, for every backend; a backend writes the
``_do_*`` methods behind them (the non-virtual interface idiom). States::

    READY ──(exception in a _do_* method)──> FAILED ──reset──> READY
      └───────────────close────────────────────┴──────close──> CLOSED

``reset(what)`` is the one way back to the start, for parts of a run as for the whole:

==========  =========================  ============================================================
``what``    of                         returns
==========  =========================  ============================================================
``all``     brain, world, loop, run    the time to 0, everything to the state right after opening,
                                       and a failed simulation to READY; this is the default
``state``   brain, world               everything but the time to the state right after opening
``poses``   world                      models and their joints to their initial poses, at rest
``colors``  world                      models to their initial colours
``brain``   run                        the brain's ``state``
``robot``   run                        the ``poses`` of the robots
``world``   run                        the ``poses`` and ``colors`` of all other models
==========  =========================  ============================================================

Devices, ports, publications and subscriptions stay open. With ``seed`` the random streams begin as those of
the new seed, else as those of the seed in force. If time continues, devices keep their values, their random
streams and their recordings. A snapshot returns to any other time: see :meth:`Simulation.restore`.
"""

from __future__ import annotations

import pickle
import re
from abc import abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from typing import Any, Literal, final

from nrp_core._support.checked_arguments import checks_arguments, require_kind
from nrp_core._support.closing import Closing
from nrp_core.clock import seconds
from nrp_core.errors import (
    CapabilityError,
    ExperimentError,
    LifecycleError,
    NrpError,
    SimulationError,
    SnapshotError,
)


class Determinism(Enum):
    """How far two runs with equal seeds agree."""

    BITWISE = "bitwise"
    """Bit for bit, on any machine."""
    MACHINE = "machine"
    """Bit for bit, on one machine with one build."""
    STATISTICAL = "statistical"
    """In distribution only."""


class State(Enum):
    """The states of the life cycle."""

    READY = "ready"
    FAILED = "failed"
    CLOSED = "closed"


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The whole state of a simulation at one time.

    Args:
        identity: the backend, options and model that it fits.
        t_ns: the time at which it was taken.
        payload: opaque bytes.
    """

    identity: str
    t_ns: int
    payload: bytes


class Simulation(Closing):
    """A brain or a world that can be stepped.

    Args:
        seed: the experiment's seed for this side.
        identity: see :attr:`identity`; its parts are separated by commas.
        name: its name in errors; by default its class.

    Attributes:
        now_ns: time reached, in nanoseconds since reset; only the simulation itself sets it.
    """

    def __init__(self, *, seed: int, identity: str, name: str = "") -> None:
        self.now_ns = 0
        self._seed = seed
        self._lifecycle = State.READY
        self._identity = identity
        self._name = name or type(self).__name__

    @property
    def seed(self) -> int:
        """The seed in force."""
        return self._seed

    @property
    def identity(self) -> str:
        """Backend, options and model; snapshots of others are refused."""
        return self._identity

    @property
    def state(self) -> State:
        """The state of the life cycle."""
        return self._lifecycle

    @final
    def run_until(self, t_ns: int) -> None:
        """Advance to exactly ``t_ns``; how a run is split into calls does not change its result.

        Raises:
            LifecycleError: the simulation is closed or failed, or ``t_ns`` lies in the past.
            SimulationError: the engine failed; its error is the cause.
        """
        self.require_ready()
        if type(t_ns) is not int:
            require_kind("run_until", "t_ns", int, t_ns)
        if t_ns < self.now_ns:
            raise LifecycleError(
                f"cannot run back to {seconds(t_ns):g} s: it is {seconds(self.now_ns):g} s already"
            )
        if t_ns > self.now_ns:
            try:
                self._advance(t_ns)
            except BaseException as error:
                self.fail("advance", error)
                raise
            if self.now_ns < t_ns:  # an engine of a world counts its time itself
                self.now_ns = t_ns

    @checks_arguments()
    def reset(self, what: Literal["all", "state"] = "all", *, seed: int | None = None) -> None:
        """Return to the state right after opening; devices and ports stay.

        Args:
            what: ``all``, including the time, or ``state``, while time continues.
            seed: a new seed; by default the one in force is used again.

        Raises:
            LifecycleError: the simulation is closed; or it failed, and ``what`` is not ``all``.
            CapabilityError: the engine cannot reset the state while time continues.
        """
        self.require_ready(or_failed=what == "all")
        if seed is not None:
            self._seed = seed
        if what == "state":
            with guarded(self, "reset its state"):
                self._reset_state()
            return
        self.now_ns = 0
        self._lifecycle = State.READY
        with guarded(self, "reset"):
            self._reset()

    @final
    def snapshot(self) -> Snapshot:
        """Save the complete state, in-flight events and random streams included."""
        self.require_ready()
        with guarded(self, "snapshot"):
            return Snapshot(self.identity, self.now_ns, pickle.dumps(self._save()))

    @final
    @checks_arguments()
    def restore(self, snapshot: Snapshot) -> None:
        """Return to a snapshot; the run then continues as it did from there.

        Raises:
            SnapshotError: the snapshot belongs to another backend, model or set of options, or the engine
                cannot read it.
        """
        self.require_ready(or_failed=True)
        if snapshot.identity != self.identity:
            then, now = _identity_difference(snapshot.identity, self.identity)
            raise SnapshotError(f"the snapshot was taken with {then}; here it is {now}")
        self._lifecycle = State.READY
        self.now_ns = snapshot.t_ns
        with guarded(self, "restore", SnapshotError):
            self._load(pickle.loads(snapshot.payload))

    @final
    def close(self) -> None:
        """Release the engine; calling it again does nothing."""
        if self._lifecycle is not State.CLOSED:
            self._lifecycle = State.CLOSED
            self._do_close()

    # -- for the two sides (brain and world), which wrap the backend's own methods

    @abstractmethod
    def _advance(self, t_ns: int) -> None: ...

    @abstractmethod
    def _reset(self) -> None: ...

    @abstractmethod
    def _reset_state(self) -> None: ...

    @abstractmethod
    def _save(self) -> object: ...

    @abstractmethod
    def _load(self, saved: Any) -> None: ...

    # -- for backends

    def _do_close(self) -> None:
        """Release the engine; by default do nothing."""

    # -- checks

    def require_ready(self, *, or_failed: bool = False) -> None:
        """Raise a LifecycleError if it is closed, or, unless that is allowed, has failed."""
        state = self._lifecycle
        if state is State.READY:
            return
        if state is State.CLOSED:
            raise LifecycleError(f"{self._name} is closed: its 'with' block has ended, or close() was called")
        if not or_failed:
            raise LifecycleError(f"{self._name} has failed; only reset, restore and close work")

    def fail(self, what: str, error: BaseException, kind: type[SimulationError] = SimulationError) -> None:
        """Mark it failed and convert a foreign exception to one of our errors; the caller raises our own.

        A request that cannot be met is refused before anything is done, and so it breaks nothing.
        """
        if isinstance(error, CapabilityError | ExperimentError):
            return
        self._lifecycle = State.FAILED
        if isinstance(error, NrpError) or not isinstance(error, Exception):
            return
        raise kind(
            f"{self._name} failed to {what} at {seconds(self.now_ns):g} s: {type(error).__name__}: {error}",
            t_ns=self.now_ns,
        ) from error


Failures = dict[int, Exception]
"""Errors by the number of the copy."""


def note_failure(failed: Failures, number: int, call: Callable[[], object]) -> None:
    """Make a call for one of several copies, and store its error, so that the others continue."""
    try:
        call()
    except Exception as error:  # noqa: BLE001 - the caller decides about each copy
        failed[number] = error


@contextmanager
def guarded(
    simulation: Simulation, what: str, kind: type[SimulationError] = SimulationError
) -> Iterator[None]:
    """Convert every exception of a backend to one of our errors; see :meth:`Simulation.fail`."""
    try:
        yield
    except BaseException as error:
        simulation.fail(what, error, kind)
        raise


def _identity_difference(one: str, other: str) -> tuple[str, str]:
    """Return the parts in which two identities differ."""
    both = [[part for part in re.split(r"[,{}]", text) if part.strip()] for text in (one, other)]
    different = [
        ", ".join(part.strip() for part in parts if part not in rest)
        for parts, rest in (both, reversed(both))
    ]
    return different[0] or one, different[1] or other
