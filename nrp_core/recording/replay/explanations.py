"""What may explain that a run is not the same again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from nrp_core._support import machine
from nrp_core.errors import ExperimentError
from nrp_core.experiment.backends import code_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.recording.folder.recording_folder import FORMAT, changed_files
from nrp_core.recording.layout import RUN_NAME
from nrp_core.recording.reading.recording import Recording

_MOST_NAMED = 5
_MACHINE = ("python", "architecture", "cpu_features")
"""What of a machine results may depend on."""


def require_format(recording: Recording) -> None:
    """Refuse a recording whose files and hashes are laid out in another way than this version's.

    Raises:
        ExperimentError: it names the version that made the recording.
    """
    found = recording.run.get("format", FORMAT)
    if found != FORMAT:
        maker = dict(recording.run.get("distributions") or {}).get("nrp-core", "of an unknown version")
        raise ExperimentError(
            f"{recording.folder}: recorded by nrp-core {maker} in format {found}; "
            f"this version replays format {FORMAT}"
        )


def explanations(recording: Recording) -> list[str]:
    """Return what of a recording is not what it was."""
    if not recording.run:
        return [f"there is no {RUN_NAME}: what ran, and with which files, is not known"]
    found = [f"{name} is not what was recorded" for name in changed_files(recording)]
    if not recording.complete:
        found.append("the recording is truncated or damaged: only its beginning is available")
    return found


def other_surroundings(recording: Recording, experiment: Experiment) -> list[str]:
    """Return which versions, code and processor are not those that it was made with."""
    then, now = dict(recording.run.get("distributions") or {}), machine.distributions()
    versions = [
        f"{name} {version} (now {now.get(name, 'none')})"
        for name, version in then.items()
        if now.get(name) != version
    ]
    found = [f"it was made with {_listed(versions)}"] if versions else []
    other = other_code(recording, experiment)
    found += [f"it was made by {other}"] if other else []
    return found + list(_of_machine(dict(recording.run.get("machine") or {}), machine.describe()))


def other_code(recording: Recording, experiment: Experiment) -> str:
    """Return whose code is not what made a recording, in words: the core's, or a backend's; empty if none."""
    now = code_of(experiment.brain.backend, experiment.world.backend)
    then = dict(recording.run.get("code") or {})
    if not then:
        return "code of which nothing is known"
    changed = [package for package, digest in now.items() if then.get(package) != digest]
    return f"other code of {' and '.join(changed)}" if changed else ""


def _of_machine(then: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    for key in _MACHINE:
        if key in then and then[key] != now[key]:
            before, after = (_words(about[key]) for about in (then, now))
            yield f"it was made on another machine: {key.replace('_', ' ')} {before} (now {after})"


def _words(value: Any) -> str:
    return " ".join(value) if isinstance(value, list) else str(value)


def _listed(names: list[str]) -> str:
    more = len(names) - _MOST_NAMED
    return ", ".join(names[:_MOST_NAMED]) + (f" and {more} more of other versions" if more > 0 else "")
