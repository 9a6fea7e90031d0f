"""What can be known of an experiment before its first step.

A :class:`~nrp_core.analysis.study.Study` reads the experiment; the checks look at it, each for one thing.
"""
