"""``smach``: states, and containers that run them in sequence, repeat one, or run several side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from collections.abc import Iterator as Iterator_
from contextlib import contextmanager
from types import ModuleType
from typing import Any, Self

from nrp_core.errors import did_you_mean
from nrp_legacy.shims.graph import log
from nrp_legacy.shims.modules import module
from nrp_legacy.shims.steps import Task, run_together

GOES_ON = ("invalid", "succeeded", "valid", "done")
"""Outcomes that mean the end of waiting; transitions may use any of them."""


class InvalidTransitionError(Exception):
    """A container that cannot be run."""


class InvalidStateError(Exception):
    """A state was added outside a container, or a second time."""


class UserData:
    """The base of states."""

    def __getitem__(self, key: str) -> Any:
        return self.__dict__[key]

    def __setitem__(self, key: str, value: Any) -> None:
        self.__dict__[key] = value

    def __contains__(self, key: str) -> bool:
        return key in self.__dict__


@contextmanager
def shared(own: UserData, given: Any) -> Iterator_[None]:
    """Pass the data of the outer container to an inner one, and its changes back."""
    is_within = isinstance(given, UserData) and given is not own
    if is_within:
        vars(own).update(vars(given))
    yield
    if is_within:
        vars(given).update(vars(own))


def execute_with(state: State, data: UserData, remapping: Mapping[str, str]) -> str:
    """Execute a state that has other names for some of the data; return its outcome.

    Args:
        state: the state.
        data: the data of the container.
        remapping: the names of the container by those of the state.
    """
    if not remapping:
        return state.execute(data)
    lent = {own: data[theirs] for own, theirs in remapping.items() if theirs in data}
    before, view = {**vars(data), **lent}, UserData()
    vars(view).update(before)
    outcome = state.execute(view)
    for key, value in vars(view).items():
        if key not in before or before[key] is not value:
            data[remapping.get(key, key)] = value
    return outcome


class State:
    """A state; override ``execute(userdata)``, which returns an outcome.

    Args:
        outcomes: its possible outcomes.
        input_keys, output_keys, io_keys: what it reads and writes; all data is shared.
    """

    def __init__(
        self,
        outcomes: Iterable[str] = (),
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        io_keys: Iterable[str] = (),
    ) -> None:
        self._outcomes = list(outcomes)
        self.is_text = isinstance(outcomes, str)
        self.reads, self.writes = [*input_keys, *io_keys], [*output_keys, *io_keys]
        self.is_preempted = False

    def execute(self, userdata: Any) -> str:
        """Execute the state and return an outcome."""
        raise NotImplementedError(f"{type(self).__name__}.execute")

    def get_registered_outcomes(self) -> tuple[str, ...]:
        """Return the possible outcomes."""
        return tuple(self._outcomes)

    def register_outcomes(self, outcomes: Iterable[str]) -> None:
        """Add outcomes."""
        self._outcomes += outcomes

    def preempt_requested(self) -> bool:
        """Return whether it was asked to end early."""
        return self.is_preempted

    def request_preempt(self) -> None:
        """Ask it to end early."""
        self.is_preempted = True

    def service_preempt(self) -> None:
        """Acknowledge the early end."""
        self.is_preempted = False

    recall_preempt = service_preempt


OUTCOMES = "_smach_outcomes"
"""Where a decorated function keeps its outcomes."""


def cb_interface(
    outcomes: Iterable[str] = (), *_keys: Iterable[str], **_more: Iterable[str]
) -> Callable[[Callable[..., str]], Callable[..., str]]:
    """Return a decorator that sets the outcomes of a function for :class:`CBState`."""
    if callable(outcomes):
        raise TypeError("cb_interface needs its outcomes: write @cb_interface(outcomes=['succeeded'])")

    def decorated(function: Callable[..., str]) -> Callable[..., str]:
        setattr(function, OUTCOMES, tuple(outcomes))
        return function

    return decorated


class CBState(State):
    """A state that calls a function.

    Args:
        cb: the function; first the user data, then ``cb_args`` and ``cb_kwargs``; it returns an outcome.
    """

    def __init__(
        self,
        cb: Callable[..., str],
        cb_args: Iterable[Any] = (),
        cb_kwargs: Mapping[str, Any] | None = None,
        outcomes: Iterable[str] = (),
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        io_keys: Iterable[str] = (),
    ) -> None:
        super().__init__([*outcomes, *getattr(cb, OUTCOMES, ())])
        self._callback, self._values, self._more = cb, tuple(cb_args), dict(cb_kwargs or {})

    def execute(self, userdata: Any) -> str:
        return self._callback(userdata, *self._values, **self._more)


class Container(State):
    """A state of states; ``with container: add(...)`` adds to the innermost one that is open.

    Args:
        outcomes: its possible outcomes.
    """

    _open: list[Any] = []  # noqa: RUF012 - one stack for all, as in smach; empty outside of `with`

    def __init__(self, outcomes: Iterable[str] = ()) -> None:
        super().__init__(outcomes)
        self.userdata = UserData()

    def __enter__(self) -> Self:
        Container._open.append(self)
        return self

    def __exit__(self, *_raised: object) -> None:
        Container._open.pop()


def opened() -> Any:
    """Return the innermost container that is open.

    Raises:
        InvalidStateError: none is.
    """
    if not Container._open:
        raise InvalidStateError("a state is added outside of a machine; indent it below 'with machine:'")
    return Container._open[-1]


class StateMachine(Container):
    """Goes from state to state until an outcome of its own.

    ``with machine: StateMachine.add(...)`` adds to the innermost machine that is open.
    """

    def __init__(self, outcomes: Iterable[str] = (), *keys: Iterable[str], **more: Iterable[str]) -> None:
        super().__init__(outcomes)
        self._states: dict[str, State] = {}
        self._transitions: dict[str, dict[str, str]] = {}
        self._remappings: dict[str, dict[str, str]] = {}
        self._initial: str | None = None
        self.has_run = False

    @staticmethod
    def add(
        label: str,
        state: State,
        transitions: Mapping[str, str] | None = None,
        remapping: Mapping[str, str] | None = None,
        **_keys: Any,
    ) -> State:
        """Add a state to the machine that is open; all data is shared.

        Args:
            label: its name for other states.
            state: the state.
            transitions: the next state, or an outcome of the machine, for each outcome.
            remapping: names of data in the machine by those in the state.

        Raises:
            InvalidStateError: the machine has a state of this label.
        """
        machine = opened()
        if label in machine._states:
            raise InvalidStateError(f"the state '{label}' already exists; rename one")
        machine._remappings[label] = dict(remapping or {})
        machine._states[label] = state
        machine._transitions[label] = dict(transitions or {})
        machine._initial = machine._initial or label
        return state

    def set_initial_state(self, labels: Iterable[str]) -> None:
        """Choose the initial state; by default the first one."""
        self._initial = next(iter(labels))

    def request_preempt(self) -> None:
        super().request_preempt()
        for state in self._states.values():
            state.request_preempt()

    def service_preempt(self) -> None:
        super().service_preempt()
        for state in self._states.values():
            state.service_preempt()

    def execute(self, userdata: Any = None) -> str:
        self.has_run = True
        with shared(self.userdata, userdata):
            return self._executed()

    def _executed(self) -> str:
        label = self._initial
        while label in self._states and label is not None:
            if self.preempt_requested() and "preempted" in self._outcomes:
                return "preempted"
            outcome = execute_with(self._states[label], self.userdata, self._remappings[label])
            label = self._next(label, outcome)
            task = Task.here()
            if task is not None:
                task.glance()
        return str(label)

    def _next(self, label: str, outcome: str) -> str:
        """Return the target of an outcome: a state, or an outcome of this machine.

        Raises:
            InvalidTransitionError: it has no target.
        """
        ways = self._transitions[label]
        meant = [outcome, *(other for other in GOES_ON if outcome in GOES_ON)]
        for known in meant:
            if known in ways:
                return ways[known]
        if outcome in self._outcomes:
            return outcome
        hint = did_you_mean(str(outcome), [*ways, *self._outcomes])
        raise InvalidTransitionError(
            f"state '{label}' ends with '{outcome}', which does not have a transition{hint}"
        )


class Sequence(StateMachine):
    """States in sequence.

    Args:
        outcomes: outcomes of the sequence.
        connector_outcome: the outcome that leads to the next state, and from the last one out.
    """

    def __init__(self, outcomes: Iterable[str], connector_outcome: str = "succeeded") -> None:
        super().__init__(outcomes)
        self._connector = connector_outcome

    @staticmethod
    def add(label: str, state: State, *given: Any, **more: Any) -> State:
        """Add a state to the sequence that is open, as :meth:`StateMachine.add` does."""
        machine = opened()
        if machine._states:
            machine._transitions[list(machine._states)[-1]].setdefault(machine._connector, label)
        return StateMachine.add(label, state, *given, **more)


class Iterator(Container):
    """Executes a state for each of some items.

    Args:
        outcomes: outcomes of the container.
        input_keys, output_keys: taken; all data is shared.
        it: the items, or a function that returns them.
        it_label: the name under which the state finds an item in its data.
        exhausted_outcome: when no item is left.
    """

    def __init__(
        self,
        outcomes: Iterable[str],
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        it: Any = (),
        it_label: str = "it_data",
        exhausted_outcome: str = "exhausted",
    ) -> None:
        super().__init__(outcomes)
        self._items, self._label, self._exhausted = it, it_label, exhausted_outcome
        self._state = State()
        self._on, self._off, self._final = set[str](), set[str](), dict[str, str | None]()

    @staticmethod
    def set_contained_state(
        _label: str,
        state: State,
        loop_outcomes: Iterable[str] = (),
        break_outcomes: Iterable[str] = (),
        final_outcome_map: Mapping[str, str | None] | None = None,
        **_more: Any,
    ) -> None:
        """Choose the state for the iterator that is open.

        Args:
            state: the state.
            loop_outcomes: outcomes after which it continues with the next item; by default all others.
            break_outcomes: outcomes that end it.
            final_outcome_map: the container's outcome for the last outcome; None: no item was left.
        """
        iterator = opened()
        iterator._state, iterator._on, iterator._off = state, set(loop_outcomes), set(break_outcomes)
        iterator._final = dict(final_outcome_map or {})

    def execute(self, userdata: Any) -> str:
        items = self._items() if callable(self._items) else self._items
        self.userdata, outcome, ended = userdata or self.userdata, None, False
        for item in items:
            self.userdata[self._label] = item
            outcome = self._state.execute(self.userdata)
            ended = outcome in self._off or bool(self._on and outcome not in self._on)
            if ended or self.preempt_requested():
                break
        meant: str | None = self._final.get(str(outcome), outcome if ended else None)
        return meant or self._exhausted


class Concurrence(Container):
    """Concurrent states: while one waits, the others continue.

    Args:
        outcomes: outcomes of the container.
        default_outcome: the outcome if no other applies.
        outcome_map: for an outcome, the outcomes of states that must all hold.
        outcome_cb: returns the outcome from those of all states.
        child_termination_cb: called with the outcomes so far whenever a state ends; returns whether to end
            the others, too.
    """

    def __init__(
        self,
        outcomes: Iterable[str],
        default_outcome: str = "",
        outcome_map: Mapping[str, Mapping[str, str]] | None = None,
        outcome_cb: Callable[[dict[str, str]], str] | None = None,
        child_termination_cb: Callable[[dict[str, str]], bool] | None = None,
        **_more: Any,
    ) -> None:
        super().__init__(outcomes)
        self._ends = child_termination_cb
        self._default, self._map, self._choose = default_outcome, outcome_map or {}, outcome_cb
        self._states: dict[str, State] = {}
        self._transitions: dict[str, dict[str, str]] = {}
        self._remappings: dict[str, dict[str, str]] = {}
        self._initial: str | None = None

    add = staticmethod(StateMachine.add)

    def execute(self, userdata: Any) -> str:
        came: dict[str, str] = {}

        def executing(label: str, state: State) -> Callable[[], None]:
            def execute() -> None:
                came[label] = execute_with(state, self.userdata, self._remappings[label])
                if self._ends is not None and self._ends(dict(came)):
                    for other in self._states.values():
                        other.request_preempt()

            return execute

        with shared(self.userdata, userdata):
            run_together([executing(label, state) for label, state in self._states.items()])
        for state in self._states.values():
            state.service_preempt()
        chosen = self._choose(came) if self._choose is not None else None
        if chosen:
            return chosen
        for outcome, needed in self._map.items():
            if all(came.get(label) == wanted for label, wanted in needed.items()):
                return outcome
        return self._default


def smach_module() -> ModuleType:
    """Return the module."""
    return module(
        "smach",
        State=State, CBState=CBState, StateMachine=StateMachine, Concurrence=Concurrence, Sequence=Sequence,
        Iterator=Iterator,
        UserData=UserData, InvalidStateError=InvalidStateError, InvalidTransitionError=InvalidTransitionError,
        cb_interface=cb_interface,
        set_loggers=lambda *_loggers: None, loginfo=log.info, logwarn=log.warning, logerr=log.error,
        logdebug=log.debug,
    )  # fmt: skip
