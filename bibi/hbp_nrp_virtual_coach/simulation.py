"""A simulation as scripts steer it."""

from __future__ import annotations

from collections.abc import Callable

from hbp_nrp_virtual_coach.brain import BrainEdits
from hbp_nrp_virtual_coach.once import say_once
from hbp_nrp_virtual_coach.records import Records
from hbp_nrp_virtual_coach.state_machines import StateMachineEdits
from hbp_nrp_virtual_coach.storage import Stored
from nrp_core.errors import CapabilityError, ExperimentError, did_you_mean
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.running.run import Run
from nrp_core.world.rigid.motion import ModelMotion
from nrp_core.world.rigid.pose import Pose

_RESETS = ("full", "robot_pose", "world", "brain")


class Simulation(BrainEdits, StateMachineEdits, Records):
    """An experiment that was launched by :meth:`.VirtualCoach.launch_experiment`; errors are ``NrpError``."""

    def __init__(self, stored: Stored, read: Callable[[], Experiment]) -> None:
        super().__init__(stored, read)
        self._homes = self._runner.call(_poses)

    def reset(self, reset_type: str) -> None:
        """Pause the simulation and reset a part of it; it stays paused.

        Args:
            reset_type: ``full``: everything, time too; ``robot_pose``: the robots return to where they began;
                ``world``: so does all else.

        Raises:
            ExperimentError: there is no such reset.
            CapabilityError: ``brain``: brain and world share one time.
        """
        if reset_type not in _RESETS:
            hint = did_you_mean(reset_type, _RESETS)
            raise ExperimentError(f"there is no reset '{reset_type}'{hint}", subject=reset_type)
        if reset_type == "brain":
            raise CapabilityError(
                "the brain is not reset alone: it shares its time with the world; use 'full'"
            )
        if reset_type == "full":
            self._runner.reset(lambda run: run.loop.reset())
        else:
            self._runner.reset(lambda run: self._return(run, robots=reset_type == "robot_pose"))

    def save_world(self) -> None:
        """Do nothing: experiments begin as their files say."""
        say_once("save_world: the world of an experiment is its SDF file, which stays as it is")

    def _return(self, run: Run, *, robots: bool) -> None:
        there = {model.name for model in run.world.scene.models}
        for name, pose in self._homes.items():
            if name in there and (name in run.experiment.world.robots) is robots:
                run.world.place(name, ModelMotion(pose))
                joints = run.world.joint_states(name).names
                run.world.set_joints(name, dict.fromkeys(joints, 0.0))


def _poses(run: Run) -> dict[str, Pose]:
    return {model.name: model.pose for model in run.world.scene.models if not model.static}
