"""What may explain that a run is not the same again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from nrp_core import machine
from nrp_core.recording.capsule import FORMAT, changed_files
from nrp_core.recording.read import Recording

_MOST_NAMED = 5
_MACHINE = ("python", "architecture", "cpu_features")
"""What of a machine results may depend on."""


def explanations(recording: Recording) -> list[str]:
    """Return what of a recording is not what it was."""
    found = [f"{name} is not what was recorded" for name in changed_files(recording)]
    if recording.run.get("format", FORMAT) != FORMAT:
        found.append("it was made by another version, whose hashes are not those of this one")
    if not recording.complete:
        found.append("the recording was cut or damaged: only its beginning is there")
    return found


def other_surroundings(recording: Recording) -> list[str]:
    """Return which versions and which processor are not those that it was made with."""
    then, now = dict(recording.run.get("distributions") or {}), machine.distributions()
    versions = [
        f"{name} {version} (now {now.get(name, 'none')})"
        for name, version in then.items()
        if now.get(name) != version
    ]
    found = [f"it was made with {_listed(versions)}"] if versions else []
    return found + list(_of_machine(dict(recording.run.get("machine") or {}), machine.describe()))


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
