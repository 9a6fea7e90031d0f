"""Examine every installed backend in a child process: some terminate the interpreter that imports them.

``python -m nrp_core.cli.survey KIND NAME`` examines one backend and prints the result as JSON.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import os
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from signal import Signals
from typing import Any

from nrp_core._support.diagnosis import Diagnosis
from nrp_core._support.json_values import to_jsonable
from nrp_core._support.probe import ChildResult, run_probe
from nrp_core.brain.backends import brains
from nrp_core.errors import BackendError, NrpError
from nrp_core.registry import Provider, Registry
from nrp_core.world.backends import worlds

KINDS: dict[str, Callable[[], Registry[Any]]] = {"brain": brains, "world": worlds}
TIMEOUT_S = 60.0

_MARK = "nrp-core survey: "


@dataclass(frozen=True, slots=True)
class Surveyed:
    """The state of an installed backend.

    Args:
        kind: ``brain`` or ``world``.
        provider: its name and distribution.
        available: whether it can be used here.
        capabilities: its capabilities with default options, as JSON data; empty if they are unknown.
        reason: why it cannot be used; empty if it can.
        remedy: the command that would make it available; empty if unknown.
        diagnoses: its diagnoses of this machine.
    """

    kind: str
    provider: Provider
    available: bool
    capabilities: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    reason: str = ""
    remedy: str = ""
    diagnoses: tuple[Diagnosis, ...] = ()

    @property
    def advice(self) -> str:
        """The reason why it cannot be used and the remedy, in one line."""
        return f"{self.reason}; try: {self.remedy}" if self.remedy else self.reason


def survey(*, refresh: bool = False) -> list[Surveyed]:
    """Examine all installed backends and return them sorted by kind and name.

    Args:
        refresh: ignore cached results.
    """
    found = [(kind, provider) for kind, registry in KINDS.items() for provider in registry().providers()]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda item: examine(*item, refresh=refresh), found))


def examine(
    kind: str, provider: Provider, *, refresh: bool = False, timeout_s: float = TIMEOUT_S
) -> Surveyed:
    """Examine one installed backend."""
    depends_on = f"{provider} {_files_stamp(provider)} {_packages_stamp()}"
    answer = run_probe(
        "nrp_core.cli.survey",
        kind,
        provider.name,
        depends_on=depends_on,
        timeout_s=timeout_s,
        refresh=refresh,
    )
    answers = [line for line in answer.output.splitlines() if line.startswith(_MARK)]
    if answer.exit_code == 0 and answers:
        return _result(kind, provider, json.loads(answers[-1].removeprefix(_MARK)))
    remedy = f"pip install --force-reinstall {provider.distribution}"
    return Surveyed(kind, provider, False, reason=_cause_of_death(answer, timeout_s), remedy=remedy)


def _result(kind: str, provider: Provider, data: dict[str, Any]) -> Surveyed:
    """Return the answer of a backend, with a reason if one of its requirements is missing."""
    diagnoses = tuple(Diagnosis(**diagnosis) for diagnosis in data["diagnoses"])
    reason, remedy = data["reason"], data["remedy"]
    missing = next((d for d in diagnoses if d.needed and not d.present), None)
    if missing is not None and not reason:
        reason, remedy = f"{missing.subject}: {missing.meaning}", missing.remedy
    return Surveyed(kind, provider, not reason, data["capabilities"], reason, remedy, diagnoses)


def _cause_of_death(answer: ChildResult, timeout_s: float) -> str:
    if answer.exit_code is None:
        return f"importing it took more than {timeout_s:g} s"
    if answer.exit_code < 0:
        return f"importing it ends the interpreter: {Signals(-answer.exit_code).name}"
    last = answer.errors.strip().splitlines()[-1:] or [""]
    return f"importing it ends the interpreter with exit code {answer.exit_code} {last[0]}".rstrip()


# -- cache keys


def _files_stamp(provider: Provider) -> int:
    """Return a number that changes with the files of the package that provides a backend and of this one."""
    packages = (provider.target.partition(":")[0].partition(".")[0], "nrp_core")
    return hash(tuple(_times_of(package) for package in packages))


def _times_of(package: str) -> tuple[int, ...]:
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        return ()
    files = (
        sorted(Path(spec.origin).parent.rglob("*.py"))
        if spec.submodule_search_locations
        else [Path(spec.origin)]
    )
    return tuple(file.stat().st_mtime_ns for file in files)


def _packages_stamp() -> int:
    """Return a number that changes when a package is installed or removed."""
    folders = [Path(entry) for entry in sys.path if entry]
    return hash(tuple(folder.stat().st_mtime_ns for folder in folders if folder.is_dir()))


# -- in the child process


def _probe(registry: Registry[Any], name: str) -> dict[str, Any]:
    found: dict[str, Any] = {"capabilities": {}, "diagnoses": [], "reason": "", "remedy": ""}
    try:
        backend = registry.load(name)
        found["diagnoses"] = [asdict(diagnosis) for diagnosis in backend.diagnose()]
        found["capabilities"] = {
            name: value
            for name, value in to_jsonable(backend.capabilities(backend.options())).items()
            if not name.startswith("_")
        }
    except BackendError as error:
        found |= {"reason": error.reason, "remedy": error.remedy}
    except NrpError as error:
        found["reason"] = str(error)
    except Exception as error:  # noqa: BLE001  it is the backend's code that runs here
        found["reason"] = f"{type(error).__name__}: {error}"
    return found


if __name__ == "__main__":
    # on a line of its own, after any output of the backend
    print("\n" + _MARK + json.dumps(_probe(KINDS[sys.argv[1]](), sys.argv[2])))
