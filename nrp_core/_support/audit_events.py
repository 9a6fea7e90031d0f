"""Audit events with which the core announces the files that it reads, so that a run can record them."""

from typing import Final

LOADS: Final = "nrp_core.loads"
"""With the top-level package of a plugin that is loaded, or of a module that an experiment's file imports."""
SEARCHES: Final = "nrp_core.searches"
"""With the name of an environment variable that lists folders in which files are searched."""
LOOKS: Final = "nrp_core.looks"
"""With a path at which a file is looked for."""
