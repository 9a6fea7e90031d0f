"""``smach``: containers that repeat a state or run several side by side, and the module."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import ModuleType
from typing import Any

from nrp_legacy.shims.graph import log
from nrp_legacy.shims.modules import module
from nrp_legacy.shims.smach import (
    CBState,
    Container,
    InvalidStateError,
    InvalidTransitionError,
    Sequence,
    State,
    StateMachine,
    UserData,
    cb_interface,
    execute_with,
    opened,
    shared,
)
from nrp_legacy.shims.steps import run_together


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
