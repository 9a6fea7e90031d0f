"""The interface of observables, the data that they can read, and their creation from text in a file."""

from __future__ import annotations

import ast
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

from nrp_core.brain.interface import Brain
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.observables.positions import GroundPositions
from nrp_core.paths import TextFrom
from nrp_core.registry import Registry
from nrp_core.scripts import Scope
from nrp_core.world.world import World

Room = Callable[[float], float]
"""Returns how much a value may change before a condition on it can change."""


@dataclass
class Surroundings:
    """What an observable can read.

    Args:
        world: the world; its engine has the state at the present physics step.
        where: the poses of models at the moment.
        named: the observables of the experiment, as they are written, by name.
        brain: the open brain; None before it is opened.
        spikes: returns the number of spikes so far of each population and view.
    """

    world: World
    where: GroundPositions
    named: Mapping[str, Any] = field(default_factory=dict)
    brain: Brain | None = None
    spikes: Callable[[], Mapping[str, int]] | None = None


class Observable(ABC):
    """A named number with a unit that a run has at each time.

    Args:
        arguments: as written behind its kind, such as ``husky`` in ``{height: husky}``.
        around: the data that it can read.

    Attributes:
        name: its name in sentences.
        unit: the unit of its values; empty for fields of messages and shares.

    Raises:
        ExperimentError: the arguments are not valid, or name something that does not exist.
        CapabilityError: the world or the brain does not report data that it needs.
    """

    unit: ClassVar[str] = ""
    hears: ClassVar[bool] = False
    """Whether messages change it, which :meth:`news` returns."""

    @abstractmethod
    def __init__(self, arguments: Any, around: Surroundings) -> None: ...

    name: str

    @abstractmethod
    def value(self, now_ns: int) -> Any:
        """Return the value at a moment, which is not before the previous one; None before the first value."""

    def news(self) -> Sequence[int]:
        """Return the times of the messages that came since the last call, ns."""
        return ()

    def unchanged_ns(self, room: Room) -> int | None:
        """Return the time for which the value changes by less than ``room``, ns.

        0: it must be read at each physics step. None: it changes with messages or with the steps of
        the loop only.
        """
        return None

    def look(self, now_ns: int) -> None:
        """Keep the value at a physics step between two steps of the loop, if it is not one of positions."""

    def save(self) -> Any:
        """Return the state that changes during a run."""
        return None

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`, in a world that was reset or restored."""


class Reading(Observable):
    """An observable that is read from the engine, at each physics step if a condition needs it."""

    def __init__(self, arguments: Any, around: Surroundings) -> None:
        self._world, self._last = around.world, 0.0
        self._seen: deque[tuple[int, float]] = deque()

    @abstractmethod
    def read(self) -> float:
        """Return the present value."""

    def look(self, now_ns: int) -> None:
        self._seen.append((now_ns, self.read()))

    def value(self, now_ns: int) -> float:
        while self._seen and self._seen[0][0] <= now_ns:
            _, self._last = self._seen.popleft()
        if now_ns >= self._world.now_ns:
            self._last = self.read()
        return self._last

    def unchanged_ns(self, room: Room) -> int | None:
        return 0

    def restore(self, saved: Any) -> None:
        self._seen.clear()


class OwnFunction(Observable):
    """A function of a user: it takes :class:`Surroundings` and returns a number, at each step of the loop."""

    def __init__(self, arguments: Any, around: Surroundings) -> None:
        given = arguments_of(arguments, "function", "file", "name", needed=["name"])
        file, name = given["file"], str(given["name"])
        folder = file.folder if isinstance(file, TextFrom) else Path.cwd()
        path = (folder / str(file)).resolve()
        if not path.is_file():
            raise ExperimentError(f"function: there is no file '{file}'")
        functions = [
            one.name for one in ast.parse(path.read_bytes()).body if isinstance(one, ast.FunctionDef)
        ]
        if name not in functions:
            raise ExperimentError(f"'{file}' has no function '{name}'{did_you_mean(name, functions)}")
        self.name = self._called = name
        self._path, self._around = path, around
        self._function: Callable[[Surroundings], float] | None = None

    def value(self, now_ns: int) -> float:
        if self._function is None:  # a check of an experiment executes nothing
            self._function = vars(Scope((), lambda _name: None).run(self._path))[self._called]
        return float(self._function(self._around))


OBSERVABLES: Registry[Callable[[Any, Surroundings], Observable]] = Registry(
    "nrp_core.observables", "observable"
)


def observable_of(written: Any, around: Surroundings) -> Observable:
    """Return an observable from its name, or from its kind and arguments, such as ``{height: husky}``.

    Raises:
        ExperimentError: the name or kind does not exist, or the arguments are not valid.
        SceneError, TopicError, CapabilityError: a named object does not exist, or is not reported.
    """
    name = ""
    if isinstance(written, str):
        name = str(written)
        if name not in around.named:
            raise ExperimentError(f"there is no observable '{name}'{did_you_mean(name, around.named)}")
        written = around.named[name]
    if not isinstance(written, Mapping) or len(written) != 1:
        raise ExperimentError(f"an observable is a name or one 'kind: arguments', not {written!r:.60}")
    ((kind, arguments),) = written.items()
    if kind not in OBSERVABLES.names():
        raise ExperimentError(
            f"there is no observable of kind '{kind}'{did_you_mean(kind, OBSERVABLES.names())}"
        )
    found = OBSERVABLES.load(kind)(arguments, around)
    if not isinstance(found, Observable):
        raise ExperimentError(f"the observable '{kind}' is not made as one, but as {type(found).__name__}")
    found.name = name or found.name
    return found


def topic_of(name: str) -> str:
    """Return the topic on which the value of an observable of an experiment is published at each step."""
    return f"/observables/{name}"


def unit_of(written: Any) -> str:
    """Return the unit of an observable as it is written; empty if it has none or is not valid."""
    kind = next(iter(written), "") if isinstance(written, Mapping) else ""
    return str(getattr(OBSERVABLES.load(kind), "unit", "")) if kind in OBSERVABLES.names() else ""


def arguments_of(
    written: Any, kind: str, first: str, *others: str, needed: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the arguments of an observable by name: a mapping, a list in order, or the first one alone.

    Raises:
        ExperimentError: one is unknown or missing.
    """
    names = (first, *others)
    if isinstance(written, Mapping):
        given = {str(key): value for key, value in written.items()}
    else:
        listed = list(written) if isinstance(written, (list, tuple)) else [written]
        given = dict(zip(names, listed, strict=False))
        if len(listed) > len(names):
            raise ExperimentError(f"{kind}: {len(listed)} arguments for {', '.join(names)}")
    for key in given:
        if key not in names:
            raise ExperimentError(f"{kind}: there is no argument '{key}'{did_you_mean(key, names)}")
    for key in (first, *needed):
        if key not in given:
            raise ExperimentError(f"{kind}: needs '{key}'")
    return given
