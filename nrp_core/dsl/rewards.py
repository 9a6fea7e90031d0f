"""Rewards that transfer functions give to synapses with reward-modulated plasticity."""

from __future__ import annotations

from math import isfinite
from typing import Any, Final

from nrp_core._support.checked_arguments import is_number
from nrp_core.brain.interface import Brain
from nrp_core.dsl.functions import Flow
from nrp_core.dsl.mappings import MappingDecorator
from nrp_core.dsl.parameters import Adapter, Binding
from nrp_core.dsl.selection import select_projection
from nrp_core.findings.refusals import no_rewards
from nrp_core.network.changes import rewarded
from nrp_core.simulation import State

_SETTABLE: Final = ("value", "held")


class Reward(Adapter):
    """What a function adds to the dopamine that a projection learns from.

    Args:
        parameter: the parameter that it is bound to, for messages.
        brain: the brain.
        projection: the label of the projection whose weights change.
        baseline: number of rewards of the running mean that is subtracted, or None.
    """

    __slots__ = ("_baseline", "_brain", "_holds", "_means", "_new", "_parameter", "_projection")

    def __init__(self, parameter: str, brain: Brain, projection: str, baseline: float | None = None) -> None:
        self._parameter, self._brain, self._projection = parameter, brain, projection
        self._baseline = baseline
        self._new: dict[str, float] = {}
        self._means = dict.fromkeys(_SETTABLE, 0.0)
        self._holds = False

    @property
    def value(self) -> float:
        """The dopamine that is added when the function has returned, 0 before the function sets it.

        It acts from this time on, as a spike of that weight on the receptor ``reward`` would; negative
        values punish. If the function raises an error, nothing is added.
        """
        return self._new.get("value", 0.0)

    @value.setter
    def value(self, value: float) -> None:
        self._set("value", value)

    @property
    def held(self) -> float:
        """A value that adds to the dopamine until the next call of the function, 0 before it is set.

        It does not decay. It is the reward of Florian's MSTDPET (2007, Neural Comput 19:1468), where weights
        follow the product of eligibility and reward.
        """
        return self._new.get("held", 0.0)

    @held.setter
    def held(self, value: float) -> None:
        self._set("held", value)

    @property
    def baseline(self) -> float:
        """The running mean that is subtracted from the next ``value``; 0 without ``baseline``."""
        return self._means["value"]

    def _set(self, name: str, value: float) -> None:
        if not is_number(value) or not isfinite(value):
            raise ValueError(f"{self._parameter}.{name} is {value!r:.60}; a reward is a finite number")
        self._new[name] = float(value)

    def refresh(self, now_ns: int) -> None:
        self._new = {}

    def commit(self) -> None:
        given = {name: self._above_mean(name, reward) for name, reward in self._new.items()}
        if "value" in given:
            self._brain.reward(self._projection, given["value"])
        if self._holds or "held" in given:
            self._hold(given.get("held", 0.0))

    def _above_mean(self, name: str, reward: float) -> float:
        """Return a reward less the running mean of those before it, which then moves towards it."""
        if self._baseline is None:
            return reward
        mean = self._means[name]
        self._means[name] = mean + (reward - mean) / self._baseline
        return reward - mean

    def _hold(self, value: float) -> None:
        self._brain.hold_reward(self._projection, value)
        self._holds = value != 0.0

    def set_active(self, active: bool) -> None:
        if not active:
            self.release()

    def release(self) -> None:
        if self._holds and self._brain.state is State.READY:
            self._hold(0.0)

    def reset(self) -> None:
        self.restore((False, dict.fromkeys(_SETTABLE, 0.0)))

    def save(self) -> Any:
        return self._holds, dict(self._means)

    def restore(self, saved: Any) -> None:
        self._new, (self._holds, means) = {}, saved
        self._means = dict(means)

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and name not in _SETTABLE:
            raise AttributeError(
                f"the reward '{self._parameter}' has no attribute '{name}' to set; valid: value, held"
            )
        super().__setattr__(name, value)

    def __repr__(self) -> str:
        return f"<reward {self._parameter} of {self._projection}>"


class MapReward(MappingDecorator):
    """Binds a parameter to the dopamine that a projection learns from.

    A running mean as the baseline makes a reward the surprise that learning needs: without it, synapses
    that are merely active drift (Frémaux et al. 2010, J Neurosci 30:13326). It begins with 0; after each
    reward R it moves by ``(R - mean) / baseline``.

    Args:
        key: name of the parameter.
        value: the projection whose weights change, e.g. ``nrp.brain.projection("eyes -> motors")``.
        baseline: number of rewards of the running mean that is subtracted from each, at least 1; None:
            nothing is subtracted. Each assignment in a call counts once, those of ``value`` and of ``held``
            for themselves.

    Raises:
        TransferFunctionError: the baseline is not such a number.
    """

    flow = Flow.ROBOT_TO_NEURON

    def __init__(self, key: str, value: Any, *, baseline: float | None = None) -> None:
        super().__init__(key)
        self.selector, self.baseline = value, baseline
        if baseline is not None and not (is_number(baseline) and baseline >= 1.0 and isfinite(baseline)):
            raise self.place.error(
                f"baseline is {baseline!r:.60}; it must be the number of rewards of its mean, 1 or more"
            )

    def _do_bind(self, binding: Binding) -> Reward:
        label = select_projection(self.selector, binding.root).label
        rewarded(binding.brain.network, label)
        if not binding.brain.capabilities.rewards:
            raise no_rewards(label)
        return Reward(self.parameter, binding.brain, label, self.baseline)

    def __str__(self) -> str:
        return f"reward of {self.selector!r}"
