"""Hooks into the moments of a step, for events, recorders and progress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

Loop = TypeVar("Loop")


@dataclass(frozen=True, slots=True)
class Hooks(Generic[Loop]):
    """Lists of functions, called in order; an exception in one ends the run.

    Attributes:
        before_step: called at the start of a step; messages published now act in this step.
        before_functions: called when brain and world have advanced, before the transfer functions run.
        after_step: called after the transfer functions, also if one of them failed.
        after_reset: called when everything is back at time 0.
        from_outside: called with topic and message before a message from outside is published.
    """

    before_step: list[Callable[[Loop], None]] = field(default_factory=list)
    before_functions: list[Callable[[Loop], None]] = field(default_factory=list)
    after_step: list[Callable[[Loop], None]] = field(default_factory=list)
    after_reset: list[Callable[[Loop], None]] = field(default_factory=list)
    from_outside: list[Callable[[str, Any], None]] = field(default_factory=list)
