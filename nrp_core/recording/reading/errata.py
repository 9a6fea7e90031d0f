"""Faults of earlier versions that may have touched a recording; ``docs/reference/errata.md`` lists all."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from nrp_core._support.packages import fingerprint

_VERSIONS: Final = ("0.2.", "0.3.")
_CURRENTS: Final = re.compile(
    r"\b(StepCurrentSource|DCSource|ACSource|NoisyCurrentSource|(dc|ac|step_current|noise)_generator)\b"
)
_IDLE: Final = re.compile(r"replaced by static_synapse|its nodes do nothing")
_MARKS: Final = ("near", "topic", "topic_stays", "stays_within")


def errata_of(run: Mapping[str, Any], folder: Path, topics: Mapping[str, int], steps: int) -> Iterator[str]:
    """Yield a sentence for each fault that may have touched a recording of versions 0.2 and 0.3.

    Args:
        run: the settings and the result of the run.
        folder: the folder of the recording, which may have copies of the experiment's files.
        topics: the number of messages of each topic of the world.
        steps: the number of steps of the loop.
    """
    version = str(dict(run.get("distributions") or {}).get("nrp-core", ""))
    same_code = dict(run.get("code") or {}).get("nrp_core") == fingerprint("nrp_core")
    if not version.startswith(_VERSIONS) or same_code:
        return
    settings = dict(run.get("settings") or {})
    about = f"recorded with version {version}"
    sources = {name for file in folder.rglob("*.py") for name, *_ in _CURRENTS.findall(_text(file))}
    if sources:
        yield (
            f"{about}: steps, starts or stops of {', '.join(sorted(sources))} may have been lost (errata 1); "
            "a new run shows it"
        )
    if len(settings.get("transfer_functions") or ()) > 1:
        yield f"{about}: the order of its files of functions may matter (errata 2); swap them to see it"
    often = sorted(name for name, messages in topics.items() if messages > steps + 1)
    if often and (_is_judged(settings) or settings.get("transfer_functions")):
        several = f"{often[0]} and {len(often) - 1} more" if len(often) > 1 else often[0]
        yield (
            f"{about}: functions, events and criteria saw only the last message of a step, and {several} had "
            "more (errata 3)"
        )
    elif _is_judged(settings):
        yield f"{about}: events and criteria did not see what happened between two steps (errata 3)"
    problems = dict(run.get("result") or {}).get("problems") or ()
    if any(_IDLE.search(str(problem)) for problem in problems):
        yield f"{about}: its verdict counts it as complete although parts of its brain did nothing (errata 5)"
    if dict(run.get("world") or {}).get("backend") == "pybullet" and any(
        "muscles" in name for name in topics
    ):
        yield f"{about}: muscles may have thrown joints out of their limits in PyBullet (errata 6)"


def _text(file: Path) -> str:
    try:
        return file.read_text("utf-8")
    except (OSError, UnicodeDecodeError):
        return ""


def _is_judged(settings: Mapping[str, Any]) -> bool:
    """Return whether the run has events or criteria that depend on bodies or topics."""
    events = [dict(one.get("when") or {}) for one in dict(settings.get("events") or {}).values()]
    criteria = [dict(one) for one in dict(settings.get("criteria") or {}).values()]
    return any(one.get(mark) for one in (*events, *criteria) for mark in _MARKS)
