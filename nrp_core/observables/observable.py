"""The interface of observables, the data that they can read, and their creation from text in a file."""

from __future__ import annotations

import ast
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, ValidationError, WithJsonSchema, create_model
from pydantic_core import ErrorDetails

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

    A class is made of :class:`Surroundings` and the arguments behind its kind, such as ``husky`` in
    ``{height: husky}``. The annotations of its parameters are the types of the arguments in files; an
    underscore at the end of a name that is a word of Python is left out there.

    Attributes:
        name: its name in sentences.
        unit: the unit of its values; empty for fields of messages and shares.

    Raises:
        ExperimentError: an argument names something that does not exist.
        CapabilityError: the world or the brain does not report data that it needs.
    """

    name: str
    unit: str = ""
    hears: ClassVar[bool] = False
    """Whether messages change it, which :meth:`news` returns."""

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

    def __init__(self, around: Surroundings) -> None:
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


FileName = Annotated[Any, WithJsonSchema({"type": "string"})]
"""The name of a file, beside the file in which it is written."""


class OwnFunction(Observable):
    """A function of a user: it takes :class:`Surroundings` and returns a number, at each step of the loop."""

    def __init__(self, around: Surroundings, file: FileName, name: str) -> None:
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


OBSERVABLES: Registry[Callable[..., Observable]] = Registry("nrp_core.observables", "observable")


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
    kind, arguments = kind_and_arguments(written)
    found = OBSERVABLES.load(kind)(around, *arguments)
    if not isinstance(found, Observable):
        raise ExperimentError(f"the observable '{kind}' is not made as one, but as {type(found).__name__}")
    found.name = name or found.name
    return found


def topic_of(name: str) -> str:
    """Return the topic on which the value of an observable of an experiment is published at each step."""
    return f"/observables/{name}"


def kind_and_arguments(written: Any) -> tuple[str, Sequence[Any]]:
    """Return the kind of a written observable, and the values of all its arguments in order.

    They are written as a mapping, a list in order, or the first one alone.

    Raises:
        ExperimentError: the kind or an argument does not exist, or is missing or of another type.
    """
    if not isinstance(written, Mapping) or len(written) != 1:
        raise ExperimentError(f"an observable is a name or one 'kind: arguments', not {written!r:.60}")
    ((kind, given),) = written.items()
    kinds = OBSERVABLES.names()
    if kind not in kinds:
        raise ExperimentError(f"there is no observable of kind '{kind}'{did_you_mean(kind, kinds)}")
    form = arguments_of(kind)
    names = list(form.model_fields)
    if not isinstance(given, Mapping):
        listed = list(given) if isinstance(given, (list, tuple)) else [given]
        if len(listed) > len(names):
            raise ExperimentError(f"{kind}: {len(listed)} arguments for {', '.join(names)}")
        given = dict(zip(names, listed, strict=False))
    try:
        read = form.model_validate(given)
    except ValidationError as error:
        first = min(error.errors(), key=lambda one: one["type"] != "extra_forbidden")
        raise ExperimentError(f"{kind}: {_fault(first, names)}") from None
    return kind, [getattr(read, name) for name in names]


def _fault(detail: ErrorDetails, names: Sequence[str]) -> str:
    name = str(detail["loc"][0])
    if detail["type"] == "extra_forbidden":
        return f"there is no argument '{name}'{did_you_mean(name, names)}"
    if detail["type"] == "missing":
        return f"needs '{name}'"
    return f"'{name}': {detail['msg'].removeprefix('Value error, ')}, not {detail['input']!r:.60}"


@cache
def arguments_of(kind: str) -> type[BaseModel]:
    """Return the arguments of a kind of observable: the parameters of its class or function but the first."""
    _, *parameters = signature(OBSERVABLES.load(kind), eval_str=True).parameters.values()
    fields: dict[str, Any] = {
        one.name.rstrip("_"): (one.annotation, ... if one.default is one.empty else one.default)
        for one in parameters
    }
    return create_model(kind, __config__=ConfigDict(extra="forbid"), **fields)
