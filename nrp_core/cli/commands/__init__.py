"""The commands, one module each: a function of the same name, with underscores for hyphens.

To add one, add its module and its name below.
"""

COMMANDS = (
    "list",
    "run",
    "publish",
    "functions",
    "validate",
    "explain",
    "map",
    "inspect",
    "replay",
    "plot",
    "video",
    "export",
    "recover",
    "new",
    "backends",
    "conformance",
    "doctor",
    "schema",
)
"""Their names, in the order of the help text."""
