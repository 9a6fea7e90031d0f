"""Audit events by which the core announces what it reads, for whoever notes what a run depends on."""

from typing import Final

LOADS: Final = "nrp_core.loads"
"""With the top-level package of a plugin that is loaded, or of a module that an experiment's file imports."""
SEARCHES: Final = "nrp_core.searches"
"""With the name of an environment variable that lists folders in which files are searched."""
