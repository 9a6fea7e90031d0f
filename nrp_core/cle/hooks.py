"""What others do at certain moments of a step: events, recorders, progress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from nrp_core.cle.engine import ClosedLoop

Hook: TypeAlias = "Callable[[ClosedLoop], None]"


@dataclass(frozen=True, slots=True)
class Hooks:
    """Functions of the loop, called in their order; what one raises ends the run.

    Attributes:
        before_step: at the time the step begins; what is published now acts in this step.
        before_functions: brain and world have arrived, no transfer function has run.
        after_step: the transfer functions have run, or the one that failed has.
        after_reset: everything is back at time 0.
        from_outside: a message from outside is about to be published; called with topic and message.
    """

    before_step: list[Hook] = field(default_factory=list)
    before_functions: list[Hook] = field(default_factory=list)
    after_step: list[Hook] = field(default_factory=list)
    after_reset: list[Hook] = field(default_factory=list)
    from_outside: list[Callable[[str, Any], None]] = field(default_factory=list)
