"""The binding of a parameter of a transfer function."""

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
    """The bindings of the parameters of one function.

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
    """The binding of a parameter, with its line in the file.

    Args:
        parameter: name of the parameter.

    Attributes:
        reads: the topic that the mapping subscribes to, if any.
        writes: the topic that the mapping publishes on, if any.
    """

    reads: Topic | None = None
    writes: Topic | None = None

    def __init__(self, parameter: str) -> None:
        self.place = SourceLine.of_caller()
        if not isinstance(parameter, str):
            raise self.place.error(f"a mapping needs the name of a parameter, not {parameter!r}")
        self.parameter = parameter

    @final
    def bind(self, binding: Binding) -> Adapter:
        """Return the parameter's value for the function.

        Raises:
            ExperimentError: neurons, topic or settings do not exist; the message names the line of the
                binding.
            CapabilityError: the backend lacks a capability.
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
        """A short description of the binding."""
