"""The commands: functions named like them, with underscores for hyphens; related ones share a module.

To add one, add its name and its module below.
"""

COMMANDS = {
    "list": "experiments",
    "run": "run",
    "publish": "control",
    "functions": "control",
    "validate": "validate",
    "explain": "explain",
    "map": "map",
    "inspect": "inspect",
    "replay": "replay",
    "plot": "plot",
    "video": "video",
    "export": "recordings",
    "recover": "recordings",
    "new": "new",
    "backends": "backends",
    "doctor": "backends",
    "cache": "cache",
    "schema": "experiments",
}
"""Their modules by name, in the order of the help text."""
