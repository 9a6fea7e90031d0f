"""The backends that an experiment names, with their options checked by their own models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeVar

from pydantic import ValidationError

from nrp_core._support.packages import fingerprint
from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.backends import brains
from nrp_core.errors import BackendError, BackendLoadError, NrpError
from nrp_core.experiment.model.collector import schema_findings
from nrp_core.experiment.model.section import Tree
from nrp_core.findings import Code, Finding, InvalidExperimentError
from nrp_core.registry import Registry
from nrp_core.world.backend import WorldBackend
from nrp_core.world.backends import worlds

Backend = TypeVar("Backend", BrainBackend, WorldBackend)


def load_backend(
    registry: Registry[Backend], side: str, name: str, options: Mapping[str, Any], source: Tree
) -> tuple[Backend, Any]:
    """Load a backend and read its options.

    Args:
        registry: the registry of the backends of that side.
        side: ``brain`` or ``world``, the section of the experiment.
        name: the backend's name.
        options: as written.
        source: the whole experiment as written.

    Returns:
        the backend and its typed options.

    Raises:
        BackendError: it is not installed or does not load.
        InvalidExperimentError: an option is wrong.
    """
    backend = registry.load(name)
    try:
        return backend, backend.options.model_validate(options)
    except ValidationError as error:
        raise InvalidExperimentError(
            schema_findings(error, backend.options, source, (side, "options"), Code.NRP202)
        ) from None


@contextmanager
def named_errors(backend: str, action: str) -> Iterator[None]:
    """Convert any exception of a backend in this block to an error that names it.

    Args:
        backend: its name.
        action: the failed action, for the message.

    Raises:
        BackendLoadError: it raised an exception that is not one of our errors.
    """
    try:
        yield
    except NrpError:
        raise
    except Exception as error:
        message = f"the backend '{backend}' does not {action}: {type(error).__name__}: {error}"
        raise BackendLoadError(message) from error


def option_findings(source: Tree) -> list[Finding]:
    """Check the options of both sides in an experiment whose other values may be wrong.

    A missing backend is not a finding here: an experiment can be read without it.
    """
    findings: list[Finding] = []
    registries: tuple[tuple[str, Registry[Any]], ...] = (("brain", brains()), ("world", worlds()))
    for side, registry in registries:
        section = source.nearest((side,))[0].plain()
        name, options = (
            section.get(key) if isinstance(section, dict) else None for key in ("backend", "options")
        )
        if isinstance(name, str) and isinstance(options, dict):
            try:
                load_backend(registry, side, name, options, source)
            except InvalidExperimentError as error:
                findings += error.findings
            except BackendError:
                continue
    return findings


def code_of(brain: str, world: str) -> dict[str, str]:
    """Return the fingerprints of the core and of two backends, by the names of their packages.

    Raises:
        UnknownBackendError, DuplicateBackendError: no package, or several, provide the backend.
    """
    packages = brains().provider(brain).package, worlds().provider(world).package
    return {package: fingerprint(package) for package in ("nrp_core", *packages)}
