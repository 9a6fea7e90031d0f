"""The commands, one module each: a function of the same name.

To add one, add its module and its name below.
"""

COMMANDS = (
    "run",
    "publish",
    "functions",
    "validate",
    "explain",
    "map",
    "inspect",
    "replay",
    "diff",
    "plot",
    "export",
    "recover",
    "new",
    "backends",
    "conformance",
    "doctor",
    "schema",
)
"""Their names, in the order of the help text."""
