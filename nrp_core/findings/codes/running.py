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
    "An option, parameter or intervention has no effect, or a bad one, in this experiment.",
    "The results do not change; the run may be slower than it could be.",
    "Remove or change what the message names.",
    "{n} options, parameters or interventions have no useful effect",
    Weight.REMARK,
)

SERVICE_REFUSED = Explanation(
    "A request or goal was rejected.",
    "The requested change was not made.",
    "Correct the request as the message says.",
    "{n} requests were rejected",
    Weight.ALTERED,
)

CALLBACK_FAILED = Explanation(
    "A callback of the experiment raised an error.",
    "The message, timer event or result that it was called for had no effect.",
    "Correct the callback.",
    "{n} callbacks raised an error",
    Weight.ALTERED,
)

MESSAGE_LOST = Explanation(
    "A message from or to another program was dropped, or cannot be carried.",
    "The receiver does not get the message.",
    "Correct the type or the values as the message says.",
    "{n} messages or topics were not carried",
    Weight.ALTERED,
)

LATE = Explanation(
    "The loop does not keep up with a body that runs in real time.",
    "Commands reach the body later than in a simulation.",
    "Use a longer time step of the loop, a faster brain backend, or a slower body.",
    "{n} times the loop was late",
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

BEYOND_THE_END = Explanation(
    "A run that continued beyond the duration of its experiment.",
    "Criteria and results are those of the longer run, which other runs of the experiment do not have.",
    "Increase `duration` in the experiment, or end the run at the duration, as `run.run()` does.",
    "{n} runs continued beyond the duration of the experiment",
    Weight.REMARK,
)
