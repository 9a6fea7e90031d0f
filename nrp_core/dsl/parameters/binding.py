"""What a parameter of a transfer function is bound to, and how."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, final

from nrp_core.brain.interface import Brain
from nrp_core.dsl.parameters.source_line import SourceLine
from nrp_core.dsl.selection.selection import BrainRoot
from nrp_core.errors import CapabilityError, ExperimentError
from nrp_core.world.world import World

if TYPE_CHECKING:
    from nrp_core.dsl.parameters.topics import Topic


class Adapter:
    """What a transfer function finds in a parameter."""

    __slots__ = ()

    def refresh(self, now_ns: int) -> None:
        """Take in what is new, right before the function runs."""

    def reset(self) -> None:
        """Return to the state at time 0."""

    def set_active(self, active: bool) -> None:
        """Work or fall silent; what is set stays."""

    def release(self) -> None:
        """Give back what was taken from brain and world."""

    def save(self) -> Any:
        """Return its own state; brain and world save theirs."""
        return None

    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave."""

    def shown(self) -> str:
        """Return what the function sees, for reports; empty where it only writes."""
        return ""


@dataclass(frozen=True, slots=True)
class Binding:
    """What the parameters of one function are bound to.

    Args:
        function: its name.
        brain, world: the two sides.
        variables: the variables that all functions of an experiment share, by key.
    """

    function: str
    brain: Brain
    world: World
    variables: dict[str, Any] = field(default_factory=dict)

    @property
    def root(self) -> BrainRoot:
        """The root that selectors are evaluated on."""
        return BrainRoot(self.brain.network)


class Mapping(ABC):
    """Says what a parameter is bound to; remembers the line that says so.

    Args:
        parameter: name of the parameter.

    Attributes:
        reads: the topic that the function subscribes to through it, if any.
        writes: the topic that the function publishes on through it, if any.
    """

    reads: Topic | None = None
    writes: Topic | None = None

    def __init__(self, parameter: str) -> None:
        self.place = SourceLine.of_caller()
        if not isinstance(parameter, str):
            raise self.place.error(f"a mapping begins with the name of a parameter, not {parameter!r}")
        self.parameter = parameter

    @final
    def bind(self, binding: Binding) -> Adapter:
        """Return what the function finds in the parameter.

        Raises:
            ExperimentError: neurons, topic or settings do not exist; it says where this was asked for.
            CapabilityError: the backend does not have it.
        """
        context = f"transfer function '{binding.function}', parameter '{self.parameter}'"
        try:
            return self._do_bind(binding)
        except ExperimentError as error:
            raise self.place.located(error, context) from None
        except CapabilityError as error:
            raise CapabilityError(f"{self.place}: {context}: {error}") from error
        except (ValueError, TypeError) as error:
            raise self.place.error(f"{context}: {error}") from error

    @abstractmethod
    def _do_bind(self, binding: Binding) -> Adapter: ...

    @abstractmethod
    def __str__(self) -> str:
        """What the parameter is bound to, in a few words."""
