"""The reward of an environment as a reward of its brain, which learns over the episodes."""

from __future__ import annotations

from typing import Any, Final

from nrp_core.brain import FloatArray
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl import Binding, MapReward
from nrp_core.experiment import Run
from nrp_core.simulation import State

_REST: Final = 5.0
"""Length of the rest between episodes in time constants of dopamine; 0.7 % of it is left."""


class BrainReward:
    """Gives the rewards of an environment to the brain of a run.

    Args:
        run: the run.
        mapping: the projection that learns, and the baseline.

    Raises:
        ExperimentError: the projection does not exist, or does not learn from rewards.
        CapabilityError: the brain takes no rewards.
    """

    def __init__(self, run: Run, mapping: MapReward) -> None:
        self._brain = run.brain
        self._reward: Any = mapping.bind(Binding("the environment", run.brain, run.world))
        network = run.brain.network
        learning = [one for one in network.projections if one.is_plastic and one.rewiring is None]
        self._plastic = [one.label for one in learning]
        taus = [one.neuromodulation.tau_d for one in network.projections if one.neuromodulation is not None]
        self._rest_ns = round(_REST * max(taus)) * NS_PER_MS

    def give(self, reward: float) -> None:
        """Reward the brain from now on."""
        self._reward.refresh(self._brain.now_ns)
        self._reward.value = reward
        self._reward.commit()

    def end_of_episode(self) -> dict[str, FloatArray]:
        """Let the last rewards act while the brain rests, and return the weights by projection.

        A reward changes weights while its dopamine lasts, so that of the last step would be lost.
        """
        brain = self._brain
        if brain.state is not State.READY:
            return {}
        if brain.now_ns:
            active = [port for port in brain.devices if port.active]
            for port in active:
                port.active = False
            brain.run_until(brain.now_ns + self._rest_ns)
            for port in active:
                port.active = True
        return {label: brain.read_weights(label) for label in self._plastic}
