"""Platforms for which the files of an experiment were written."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
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
    """The object of an entry point in ``nrp_core.platforms``, which has the platform's name in experiments.

    Args:
        options: the class of its options in an experiment.
        maker: returns the maker of the parts of an experiment, given these options.
        described: returns the experiment that a document of the platform describes, if it is one; it gets
            the file and overrides.
    """

    options: type[Section]
    maker: Callable[[Experiment, Any], PartMaker]
    described: Callable[[Path, Sequence[str]], Experiment | None] | None = None


PLATFORMS: Registry[Platform] = Registry("nrp_core.platforms", "platform")


def with_platform(experiment: Experiment) -> Experiment:
    """Return an experiment with the maker of its platform, if it names one.

    Raises:
        InvalidExperimentError: the platform is not installed, or its options are wrong.
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


def described_by(path: Path, overrides: Sequence[str] = ()) -> Experiment | None:
    """Return the experiment described by a file that names a brain or a body besides its functions.

    Raises:
        InvalidExperimentError: it belongs to a platform, and cannot be read.
    """
    for name in PLATFORMS.names():
        platform = PLATFORMS.load(name)
        found = None if platform.described is None else platform.described(path, overrides)
        if found is not None:
            return found
    return None
