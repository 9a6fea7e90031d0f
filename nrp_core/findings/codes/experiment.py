"""Findings about the experiment file: its keys, values, files, backends, events and criteria."""

from nrp_core.findings.codes.explanation import Explanation, Weight

NOT_READABLE = Explanation(
    "The file, or the experiment that it extends, cannot be read.",
    "The file cannot be read, so nothing else is checked.",
    "Correct the line or name in the message: check indentation, brackets, and the space after each colon.",
    "{n} files cannot be read",
    Weight.ALTERED,
)

UNKNOWN_KEY = Explanation(
    "An unknown key, or a missing one that the format requires.",
    "An unknown key would be ignored; a required key does not have a default value.",
    "Use the key or command that the message suggests; `nrp schema experiment` lists those of experiments.",
    "{n} unknown or missing keys",
    Weight.ALTERED,
)

WRONG_VALUE = Explanation(
    "A value, option, parameter, override or intervention of the wrong kind, out of range, or not declared.",
    "The run would differ from what you intended.",
    "Write a key and a value of the kind that the message names, within its limits; `nrp inspect EXPERIMENT` "
    "lists the parameters.",
    "{n} wrong values, options or parameters",
    Weight.ALTERED,
)

MISSING_FILE = Explanation(
    "A file, module or package that does not exist.",
    "What uses it cannot be built, or does without it.",
    "Correct the path, which is relative to the folder of the file that contains it, or install the module.",
    "{n} files or modules do not exist",
    Weight.ALTERED,
)

NO_SUCH_REFERENCE = Explanation(
    "An event or criterion refers to something that does not exist.",
    "The event could never happen, or the criterion could never be decided.",
    "Use one of the names in the message.",
    "{n} events or criteria refer to something that does not exist",
    Weight.ALTERED,
)

NEVER = Explanation(
    "An event, condition or state that can never happen, or did not happen by the end of the run.",
    "Its messages are not published, and what waits for it does not happen either.",
    "Check the times: an experiment file needs units; `t` is in seconds from the start of the run.",
    "{n} events, conditions or states never happen",
    Weight.REMARK,
)

DEGREES = Explanation(
    "An angle without a unit exceeds a full turn.",
    "Numbers without a unit are radians; 180 rad are nearly 29 turns.",
    "Write the unit: `180 deg`.",
    "{n} angles without a unit exceed a full turn",
    Weight.REMARK,
)
