"""Platforms that an experiment says its files were written for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from nrp_core.errors import BackendError
from nrp_core.experiment.model.experiment import Experiment, PartMaker
from nrp_core.experiment.model.schema_findings import schema_findings
from nrp_core.experiment.model.section import Section
from nrp_core.findings import Code, InvalidExperimentError
from nrp_core.registry import Registry


@dataclass(frozen=True, slots=True)
class Platform:
    """What an entry point in ``nrp_core.platforms``, named as experiments write it, is.

    Args:
        options: what can be said of it in an experiment.
        maker: makes what makes the parts of an experiment, given these.
    """

    options: type[Section]
    maker: Callable[[Experiment, Any], PartMaker]


PLATFORMS: Registry[Platform] = Registry("nrp_core.platforms", "platform")


def with_platform(experiment: Experiment) -> Experiment:
    """Return an experiment whose parts are made as on the platform that it names, if it names one.

    Raises:
        InvalidExperimentError: that is not installed, or its options are wrong.
    """
    section = experiment.compatibility
    if section is None:
        return experiment
    try:
        platform = PLATFORMS.load(section.platform)
        options = platform.options.model_validate(section.options)
    except BackendError as error:
        place = experiment.place("compatibility", "platform")
        raise InvalidExperimentError([place.finding(Code.NRP205, str(error))]) from error
    except ValidationError as error:
        above = "compatibility", "options"
        raise InvalidExperimentError(
            schema_findings(error, platform.options, experiment.source, above, Code.NRP206)
        ) from None
    return experiment.with_maker(platform.maker(experiment, options))
