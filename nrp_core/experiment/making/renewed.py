"""The plan of one more run of an experiment that runs already."""

from __future__ import annotations

from dataclasses import replace

from nrp_core.experiment.making.maker import maker_of
from nrp_core.experiment.making.parameters import with_parameters
from nrp_core.experiment.making.prepare import Plan
from nrp_core.experiment.model.collector import Collector


def renewed(plan: Plan) -> Plan:
    """Return the plan with transfer functions of its own, because files may keep values between calls.

    Network and scene, which never change, are those of the first plan.

    Raises:
        InvalidExperimentError: a file of transfer functions has changed since, and is wrong.
    """
    collector = Collector(plan.experiment.source)
    experiment, _ = with_parameters(plan.experiment, collector)
    functions = tuple(maker_of(experiment).functions(experiment, collector))
    collector.raise_errors()
    kept = {function.name for function in plan.functions}  # others were left out, with a finding
    return replace(plan, functions=tuple(each for each in functions if each.name in kept))
