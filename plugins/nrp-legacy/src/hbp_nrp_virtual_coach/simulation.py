"""A simulation as scripts steer it."""

from __future__ import annotations

from hbp_nrp_virtual_coach.brain import BrainEdits
from hbp_nrp_virtual_coach.once import log, say_once
from hbp_nrp_virtual_coach.records import Records
from hbp_nrp_virtual_coach.state_machines import StateMachineEdits
from nrp_core.errors import ExperimentError, did_you_mean

_RESETS = ("full", "robot_pose", "world", "brain")


class Simulation(BrainEdits, StateMachineEdits, Records):
    """An experiment that was launched by :meth:`.VirtualCoach.launch_experiment`; errors are ``NrpError``."""

    __logger = log  # scripts quieten it: sim._Simulation__logger.setLevel(...)

    def reset(self, reset_type: str) -> None:
        """Pause the simulation and reset a part of it; it stays paused.

        Args:
            reset_type: ``full``: everything, time too; ``robot_pose``: the robots return to where they began;
                ``world``: so does all else; ``brain``: the network begins anew, while time goes on.

        Raises:
            ExperimentError: there is no such reset.
            CapabilityError: the engine cannot put bodies elsewhere.
        """
        if reset_type not in _RESETS:
            hint = did_you_mean(reset_type, _RESETS)
            raise ExperimentError(f"there is no reset '{reset_type}'{hint}", subject=reset_type)
        part = {"robot_pose": "robot"}.get(reset_type, reset_type)
        self._runner.reset(lambda run: run.loop.reset() if part == "full" else run.reset(part))

    def save_world(self) -> None:
        """Do nothing: experiments begin as their files say."""
        say_once("save_world: the world of an experiment is its SDF file, which stays as it is")
