"""The folder of a sweep: its description, journals, tables, and recordings if requested."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from nrp_core._support.writing import writing
from nrp_core.errors import ExperimentError
from nrp_lab.sweep.plan import Plan

ABOUT = "sweep.json"
RECORDINGS = "recordings"
_WORDS = {
    "experiment": "experiment",
    "files": "files of the experiment",
    "settings": "settings",
    "vary": "keys that vary",
    "measure": "metrics",
    "until_ns": "end time",
    "stop_when_failed": "criteria that stop a run",
    "code": "version of the code",
    "search": "settings of the search",
}


def claim(folder: Path, plan: Plan) -> None:
    """Make the folder of a sweep, or reuse the existing one.

    Values and designs may differ, so that a sweep can be extended.

    Raises:
        ExperimentError: it contains other files, another sweep or another search, or cannot be written.
    """
    path = folder / ABOUT
    if path.is_file():
        _require_same(read_about(folder)["identity"], plan, folder)
    elif folder.is_dir() and any(folder.iterdir()):
        raise ExperimentError("the folder contains other files; choose another (--out)", path=folder)
    else:
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
    about = {
        "identity": plan.identity,
        "keys": plan.sweep.sampled,
        "design": str(plan.sweep.design),
        "runs": len(plan),
        "source": plan.experiment,
    }
    with writing(path):
        draft = path.with_suffix(".draft")
        draft.write_text(json.dumps(about, indent=1) + "\n", "utf-8")
        draft.replace(path)


def read_about(folder: Path) -> dict[str, Any]:
    """Return the description in a folder.

    Raises:
        ExperimentError: the folder does not contain a sweep.
    """
    path = folder / ABOUT
    try:
        found = json.loads(path.read_text("utf-8"))
        assert isinstance(found["identity"], dict)
    except (OSError, ValueError, KeyError, TypeError, AssertionError) as error:
        raise ExperimentError(f"the folder does not contain a sweep ({ABOUT})", path=folder) from error
    return found  # type: ignore[no-any-return]


def _require_same(there: dict[str, Any], plan: Plan, folder: Path) -> None:
    here = json.loads(json.dumps(plan.identity))
    shared = there.get("code", {}).keys() & here["code"].keys()  # a sweep may add a backend
    there, here = ({**one, "code": {name: one["code"][name] for name in shared}} for one in (there, here))
    other = [words for key, words in _WORDS.items() if there.get(key) != here[key]]
    if other:
        kind = "search" if there.get("search") else "sweep"
        raise ExperimentError(
            f"the folder contains another {kind}, with different {', '.join(other)}; choose another (--out)",
            path=folder,
        )
