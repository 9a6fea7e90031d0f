"""Every kind of finding, with the explanation that ``nrp explain`` prints.

A code never changes its meaning, so that people can look it up and scripts can rely on it; numbers of
``removed.py`` are not used again.
``docs/reference/findings.md`` is generated from this table.
"""

from __future__ import annotations

from enum import Enum, unique

from nrp_core.findings.codes import (
    backends,
    brain,
    experiment,
    functions,
    neurorobotics_platform,
    running,
    world,
)
from nrp_core.findings.codes.explanation import Weight


@unique
class Code(Enum):
    """A kind of finding; its value explains it."""

    NRP200 = experiment.NOT_READABLE
    NRP201 = experiment.UNKNOWN_KEY
    NRP202 = experiment.WRONG_VALUE
    NRP204 = experiment.MISSING_FILE
    NRP205 = backends.NO_BACKEND
    NRP208 = brain.SCRIPT_FAILED
    NRP209 = world.NOT_READABLE
    NRP210 = functions.WRONG_DECLARATION
    NRP211 = brain.NO_SUCH_NEURONS
    NRP212 = world.WRONG_TOPIC
    NRP213 = experiment.NO_SUCH_REFERENCE
    NRP216 = backends.NO_CAPABILITY
    NRP217 = backends.APPROXIMATED
    NRP218 = functions.NO_SUCH_IMPORT
    NRP219 = functions.MAPPING_MISMATCH
    NRP229 = functions.TWO_PUBLISHERS
    NRP231 = functions.SILENT_SOURCE
    NRP235 = functions.SAME_NAME
    NRP237 = functions.RETURN_VALUE
    NRP238 = functions.DELAY
    NRP239 = functions.NOT_CHECKED
    NRP240 = functions.WRONG_CALL
    NRP243 = functions.NOT_REPRODUCIBLE
    NRP246 = functions.UNDEFINED_NAME
    NRP248 = experiment.NEVER
    NRP249 = experiment.DEGREES
    NRP253 = functions.REASSIGNED_PARAMETER
    NRP255 = neurorobotics_platform.CONVERTED
    NRP256 = world.ROBOT_LEFT_OUT
    NRP258 = world.MESH_REPLACED
    NRP260 = world.PART_LEFT_OUT
    NRP262 = world.SENSOR_NOT_SIMULATED
    NRP264 = world.VALUE_REPLACED
    NRP265 = world.NOT_CONTROLLED
    NRP266 = world.RENAMED
    NRP269 = brain.BRAIN_LEFT_OUT
    NRP272 = running.FUNCTION_LEFT_OUT
    NRP276 = running.ENDED_BY_ERROR
    NRP277 = running.NUMERICAL
    NRP278 = running.REPORTED
    NRP279 = running.NO_EFFECT
    NRP280 = running.SERVICE_REFUSED
    NRP282 = running.MESSAGE_LOST
    NRP284 = running.RECORDING_INCOMPLETE
    NRP285 = running.REPLAY_DIFFERS
    NRP291 = world.STARTS_INSIDE
    NRP292 = world.NO_GROUND
    NRP294 = running.INTERRUPTED
    NRP297 = brain.IMPLAUSIBLE
    NRP299 = world.BEYOND_LIMIT
    NRP301 = functions.HIDDEN_STATE
    NRP306 = world.STARTS_HIGH
    NRP308 = brain.UNLIKE_SCRIPT
    NRP319 = functions.MESSAGE_OVERWRITTEN
    NRP330 = functions.NOT_KEPT
    NRP355 = functions.MESSAGE_NOT_SENT
    NRP356 = functions.NO_PREPROCESSED_RESULT
    NRP357 = functions.WAITS
    NRP358 = functions.IMPOSSIBLE_COLOUR
    NRP370 = world.TILTED_START
    NRP371 = world.LENGTH_UNIT
    NRP372 = world.STEP_UNIT
    NRP374 = world.OWN_ROBOT_VIEW
    NRP375 = world.WHEELS_WITHOUT_CONTACT
    NRP376 = world.TWO_CONTROLLERS
    NRP377 = brain.UNREACHABLE_THRESHOLD
    NRP378 = functions.WRITES_FILE
    NRP379 = functions.WRONG_TIME_STEP
    NRP380 = functions.BEYOND_SCANNER
    NRP381 = world.POSE_UNIT
    NRP382 = world.ROBOT_LOST

    def __repr__(self) -> str:
        return f"Code.{self.name}"

    @property
    def summary(self) -> str:
        """The mistake, in one sentence."""
        return self.value.summary

    @property
    def why(self) -> str:
        """The consequence."""
        return self.value.why

    @property
    def suggestion(self) -> str:
        """How to fix it."""
        return self.value.suggestion

    @property
    def weight(self) -> Weight:
        """The effect of a warning of this code on a run."""
        return self.value.weight

    def counted(self, n: int) -> str:
        """Return the headline of ``n`` findings of this code, n > 1."""
        return self.value.counted.format(n=n)
