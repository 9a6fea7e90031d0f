"""Static analysis of an experiment, before its first step.

A :class:`~nrp_core.checks.study.Study` reads the experiment; each check looks for one kind of mistake in
it.
"""
