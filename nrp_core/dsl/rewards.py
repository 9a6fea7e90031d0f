"""Rewards that transfer functions give to synapses with reward-modulated plasticity."""

from __future__ import annotations

from math import isfinite
from typing import Any

from nrp_core._support.checked_arguments import is_number
from nrp_core.brain.changes import rewarded
from nrp_core.brain.interface import Brain
from nrp_core.dsl.functions import Flow
from nrp_core.dsl.mappings import MappingDecorator
from nrp_core.dsl.parameters import Adapter, Binding
from nrp_core.dsl.selection import select_projection
from nrp_core.findings.refusals import no_rewards


class Reward(Adapter):
    """What a function adds to the dopamine that a projection learns from.

    Args:
        parameter: the parameter that it is bound to, for messages.
        brain: the brain.
        projection: the label of the projection whose weights change.
    """

    __slots__ = ("_brain", "_parameter", "_projection", "_value")

    def __init__(self, parameter: str, brain: Brain, projection: str) -> None:
        self._parameter, self._brain, self._projection = parameter, brain, projection
        self._value = 0.0

    @property
    def value(self) -> float:
        """The dopamine that is added when the function has returned, 0 before the function sets it.

        It acts from this time on, as a spike of that weight on the receptor ``reward`` would; negative
        values punish. If the function raises an error, nothing is added.
        """
        return self._value

    @value.setter
    def value(self, value: float) -> None:
        if not is_number(value) or not isfinite(value):
            raise ValueError(f"{self._parameter}.value is {value!r:.60}; a reward is a finite number")
        self._value = float(value)

    def refresh(self, now_ns: int) -> None:
        self._value = 0.0

    def commit(self) -> None:
        self._brain.reward(self._projection, self._value)

    def reset(self) -> None:
        self._value = 0.0

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and name != "value":
            raise AttributeError(f"the reward '{self._parameter}' has no attribute '{name}'; set its value")
        super().__setattr__(name, value)

    def __repr__(self) -> str:
        return f"<reward {self._parameter} of {self._projection}>"


class MapReward(MappingDecorator):
    """Binds a parameter to the dopamine that a projection learns from.

    Args:
        key: name of the parameter.
        value: the projection whose weights change, e.g. ``nrp.brain.projection("eyes -> motors")``.
    """

    flow = Flow.ROBOT_TO_NEURON

    def __init__(self, key: str, value: Any) -> None:
        super().__init__(key)
        self.selector = value

    def _do_bind(self, binding: Binding) -> Reward:
        label = select_projection(self.selector, binding.root).label
        rewarded(binding.brain.network, label)
        if not binding.brain.capabilities.rewards:
            raise no_rewards(label)
        return Reward(self.parameter, binding.brain, label)

    def __str__(self) -> str:
        return f"reward of {self.selector!r}"
