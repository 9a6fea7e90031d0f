"""What a parameter of a transfer function is bound to, and how."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, final

from nrp_core.brain.interface import Brain
from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.dsl.parameters.source_line import SourceLine
from nrp_core.dsl.parameters.topics import Topic
from nrp_core.dsl.selection.selection import BrainRoot
from nrp_core.errors import CapabilityError, ExperimentError
from nrp_core.world.world import World


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
