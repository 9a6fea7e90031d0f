"""Possible reasons for differences of a replay."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from nrp_core._support import machine
from nrp_core.errors import ExperimentError
from nrp_core.experiment.backends import code_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level
from nrp_core.recording.folder.recording_folder import FORMAT, OLDEST_FORMAT
from nrp_core.recording.layout import RUN_NAME
from nrp_core.recording.reading.check import Check
from nrp_core.recording.reading.recording import Recording

_MOST_NAMED = 5
_MACHINE = ("python", "architecture", "cpu_features")
"""The properties of a machine that results may depend on."""


def require_format(recording: Recording) -> None:
    """Refuse a recording with another layout of files and hashes than this version's.

    Raises:
        ExperimentError: it has another layout; the message names the version that made it.
    """
    found = recording.run.get("format", FORMAT)
    if found not in range(OLDEST_FORMAT, FORMAT + 1):
        maker = dict(recording.run.get("distributions") or {}).get("nrp-core", "of an unknown version")
        raise ExperimentError(
            f"{recording.folder}: recorded by nrp-core {maker} in format {found}; "
            f"this version replays formats {OLDEST_FORMAT} to {FORMAT}"
        )


def explanations(recording: Recording, check: Check) -> Iterator[Finding]:
    """Yield findings about a recording itself: files that were changed or are missing, and others."""
    if not recording.run:
        yield _differs(f"it has no {RUN_NAME}, so the versions and files of its run are unknown", RUN_NAME)
        return
    for flaw in check.flaws:
        yield _differs(str(flaw), flaw.file)
    yield from map(_differs, check.notes)


def other_surroundings(recording: Recording, experiment: Experiment) -> Iterator[Finding]:
    """Yield findings about versions, code and processor that have changed since the recording."""
    then, now = dict(recording.run.get("distributions") or {}), machine.distributions()
    versions = [
        f"{name} {version} (now {now.get(name, 'none')})"
        for name, version in then.items()
        if now.get(name) != version
    ]
    if versions:
        yield _differs(f"it was made with {_listed(versions)}")
    if other := other_code(recording, experiment):
        yield _differs(f"it was made by {other}")
    yield from map(_differs, _of_machine(dict(recording.run.get("machine") or {}), machine.describe()))


def _differs(message: str, subject: str | None = None) -> Finding:
    return Finding(Code.NRP285, message, Level.WARNING, subject=subject)


def other_code(recording: Recording, experiment: Experiment) -> str:
    """Return a text that names code changed since the recording, of the core or a backend; empty if none."""
    now = code_of(experiment.brain.backend, experiment.world.backend)
    then = dict(recording.run.get("code") or {})
    if not then:
        return "unknown code"
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
    return ", ".join(names[:_MOST_NAMED]) + (f" and {more} more with other versions" if more > 0 else "")
