"""Findings about the experiment file: its keys, values, files, backends, events and criteria."""

from nrp_core.findings.codes.explanation import Explanation, Weight

NOT_READABLE = Explanation(
    "The file is not valid YAML, or not text.",
    "The file cannot be read, so nothing else is checked.",
    "Correct the reported line: check indentation, brackets, and the space after each colon.",
    "{n} files cannot be read",
    Weight.ALTERED,
)

UNKNOWN_KEY = Explanation(
    "A key that the format does not have.",
    "The key would be ignored, and the intended setting would keep its default.",
    "Use the key or command that the message suggests; `nrp schema experiment` lists those of experiments.",
    "{n} unknown keys",
    Weight.ALTERED,
)

WRONG_VALUE = Explanation(
    "A value of the wrong type, or out of range.",
    "The run would differ from what you intended.",
    "Use a value of the type in the message, within its limits.",
    "{n} wrong values",
    Weight.ALTERED,
)

MISSING_KEY = Explanation(
    "A required key is missing.",
    "The key does not have a default value.",
    "Add the key; `nrp schema experiment` shows its format.",
    "{n} missing keys",
    Weight.ALTERED,
)

MISSING_FILE = Explanation(
    "A file that does not exist.",
    "The experiment cannot be built without the file.",
    "Correct the path; relative paths start at the folder of the file that contains them.",
    "{n} files do not exist",
    Weight.ALTERED,
)

STEPS_DO_NOT_DIVIDE = Explanation(
    "Time steps that do not divide each other.",
    "Brain and world synchronize at the end of every loop step, so both must reach that time exactly.",
    "Choose a loop period that is a multiple of the time steps of both sides.",
    "{n} time steps do not divide each other",
    Weight.ALTERED,
)

LONG_STEP = Explanation(
    "The time step is too long for a closed loop.",
    "Brain and robot exchange values only once in a step, so the robot reacts late.",
    "Shorten `timestep`; 20 ms is usual.",
    "{n} time steps are too long for a closed loop",
    Weight.REMARK,
)

NO_SUCH_REFERENCE = Explanation(
    "An event or criterion refers to something that does not exist.",
    "The event could never happen, or the criterion could never be decided.",
    "Use one of the names in the message.",
    "{n} events or criteria refer to something that does not exist",
    Weight.ALTERED,
)

BASE_NOT_READABLE = Explanation(
    "The experiment that this one extends cannot be read.",
    "The inherited settings are missing.",
    "Correct the name under `extends`; an experiment cannot extend itself.",
    "{n} extended experiments cannot be read",
    Weight.ALTERED,
)

WRONG_OVERRIDE = Explanation(
    "An override that cannot be applied.",
    "The run would differ from the one that you requested.",
    "Write `dotted.key=value`, with a key of the experiment and a value in YAML.",
    "{n} overrides cannot be applied",
    Weight.ALTERED,
)

NEVER = Explanation(
    "An event or condition that can never happen.",
    "The run ends earlier, or two events wait for each other.",
    "Check the times: an experiment file needs units; `t` is in seconds from the start of the run.",
    "{n} events or conditions can never happen",
    Weight.REMARK,
)

MISSED_EVENT = Explanation(
    "An event did not happen by the end of the run.",
    "Its messages were never published, and criteria that count from it were never evaluated.",
    "Correct its condition, or give the run more time.",
    "{n} events never happened",
    Weight.REMARK,
)

DEGREES = Explanation(
    "An angle without a unit exceeds a full turn.",
    "Numbers without a unit are radians; 180 rad are nearly 29 turns.",
    "Write the unit: `180 deg`.",
    "{n} angles without a unit exceed a full turn",
    Weight.REMARK,
)

WRONG_PARAMETER = Explanation(
    "A parameter that the script does not declare, or a value that does not fit its declaration.",
    "The script would run with another value than the one that you intended.",
    "Use a declared name, and a value of its type, in a unit that can be converted, within its range; "
    "`nrp inspect EXPERIMENT` lists the parameters.",
    "{n} parameters do not fit",
    Weight.ALTERED,
)

UNREADABLE_PARAMETER = Explanation(
    "A declaration of a parameter that cannot be read.",
    "Parameters are checked without executing the script, so their declarations must be readable.",
    'Declare it with literals: `gain = sim.parameter("gain", 1.0, unit="mV", low=0, high=5, doc="...")`.',
    "{n} declarations of parameters cannot be read",
    Weight.ALTERED,
)

CONTRADICTORY_PARAMETER = Explanation(
    "A declaration of a parameter that contradicts itself or another one.",
    "No value satisfies the declarations, so the script is not executed.",
    "Make default, range and unit consistent; two declarations of one name must be equal.",
    "{n} declarations of parameters contradict themselves or each other",
    Weight.ALTERED,
)
