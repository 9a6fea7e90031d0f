"""Checks of an experiment, which are not part of the path from its file to its run.

:func:`~nrp_core.checks.validate.check` takes the plan of a run, or the parts of an experiment, and returns
findings. Nothing that makes or runs an experiment imports this package.
"""
