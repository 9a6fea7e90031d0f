"""Findings about a run: parts that are left out or fail, and reports of engines, recordings and replays."""

from nrp_core.findings.codes.explanation import Explanation, Weight

FUNCTION_LEFT_OUT = Explanation(
    "A transfer function or state machine is left out, or stopped by an error.",
    "The experiment runs without it.",
    "Correct the cause that the message names; with `strict: true` the experiment does not run without it.",
    "{n} transfer functions or state machines are left out or stopped",
    Weight.INCOMPLETE,
)

ENDED_BY_ERROR = Explanation(
    "An error of an engine or of the experiment ended the run early.",
    "Everything after this time is missing.",
    "Correct the cause that the message names.",
    "{n} errors ended the run",
    Weight.INCOMPLETE,
)

NUMERICAL = Explanation(
    "A number of an engine or a variable became NaN, inaccurate, or exceeded its range.",
    "The results after this time may be wrong.",
    "Use a shorter time step or smaller values; in a function, test that there is something to compute with.",
    "{n} numerical problems",
    Weight.ALTERED,
)

REPORTED = Explanation(
    "A report of an engine that does not have a code of its own.",
    "The message describes the difference.",
    "Consult the documentation of the engine.",
    "{n} reports of engines",
    Weight.ALTERED,
)

NO_EFFECT = Explanation(
    "An option, parameter or intervention has no effect, or a bad one, or the run went beyond its duration.",
    "The results do not change, or they are those of a longer run.",
    "Remove or change what the message names.",
    "{n} options, parameters or interventions have no useful effect",
    Weight.REMARK,
)

SERVICE_REFUSED = Explanation(
    "A request or goal was rejected, or a callback of the experiment raised an error.",
    "The requested change was not made, or the message or event had no effect.",
    "Correct the request or the callback as the message says.",
    "{n} requests were rejected or callbacks failed",
    Weight.ALTERED,
)

MESSAGE_LOST = Explanation(
    "A message from or to another program was dropped, or cannot be carried.",
    "The receiver does not get the message.",
    "Correct the type or the values as the message says.",
    "{n} messages or topics were not carried",
    Weight.ALTERED,
)

RECORDING_INCOMPLETE = Explanation(
    "A part of the run cannot be recorded.",
    "The run is unaffected; the recording lacks this part, and a replay may differ.",
    "No action is needed unless the part is needed later; the message names it.",
    "{n} parts of the run are not recorded",
    Weight.REMARK,
)

REPLAY_DIFFERS = Explanation(
    "The replay does not have the same conditions as the recorded run.",
    "This may explain a difference from the recording.",
    "Replay with the version, machine and files of the recording if the difference matters.",
    "{n} conditions differ from the recorded run",
    Weight.REMARK,
)

INTERRUPTED = Explanation(
    "The run was interrupted or killed.",
    "Everything after this time is missing; criteria that were not decided by then remain open.",
    "Run the experiment again; `--until` ends a run early without an interruption.",
    "{n} interruptions",
    Weight.INCOMPLETE,
)
