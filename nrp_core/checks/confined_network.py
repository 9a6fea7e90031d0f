"""Describe a network without building it in this process.

A brain script is the only user code that has to be executed for a check. It runs in a child process without
network access and with limits of time and memory, which can write only temporary files. The answer is kept
for as long as the script, its imports, the environment variables that it reads, and the programs that read it
stay the same.
"""

from __future__ import annotations

import ast
import base64
import hashlib
import json
import pickle
import signal
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nrp_core.brain
from nrp_core import errors
from nrp_core._support.confinement import have_changed
from nrp_core._support.machine import cores
from nrp_core._support.probe import ChildResult, run_module, run_probe
from nrp_core.brain.backend import BrainBackend, BrainOptions
from nrp_core.checks.network_summary import NetworkSummary, skeleton_of, summary_from, summary_of
from nrp_core.errors import NetworkError, NrpError, SlowScriptError, UncheckedScriptError
from nrp_core.experiment.making.maker import build_here
from nrp_core.experiment.making.plan import Side
from nrp_core.findings import Finding, Findings
from nrp_core.network.data import Network
from nrp_core.network.files import read_network

TIME_LIMIT_S = 20.0
_DAY_S = 86_400.0
_LARGE = 10_000_000
CHILD = "nrp_core.checks.sandbox"


class ConfinedBuild:
    """Builds networks in a confined child process.

    Args:
        brain: the backend that reviews the network; None: no review.
        limit_s: time that a script may take, s, if that is less than :data:`TIME_LIMIT_S`; time in which
            other programs had the processors does not count.

    Attributes:
        summary: facts about the last network.
    """

    def __init__(self, brain: Side[BrainBackend] | None, limit_s: float | None = None) -> None:
        self._brain = brain
        self._limit_s = min(TIME_LIMIT_S, limit_s or TIME_LIMIT_S)
        self.summary = NetworkSummary()
        self._warnings = Findings()
        self._refusal: NrpError | None = None

    def __call__(self, make: Callable[[], Network]) -> Network:
        """Return the network to be made without its synapses, parameters and positions.

        Raises:
            NrpError: the error of ``make``.
        """
        backend, options = (self._brain.backend, self._brain.options) if self._brain else (None, None)
        question = _question(make, backend, _parts(options))
        if question is None:
            network = build_here(make)
            self.summary = summary_of(network)
            return network
        data = self._answer(question, _contents(make, backend))
        self._warnings = Findings(Finding.from_dict(one) for one in data["warnings"])
        self._refusal = _error_of(data["refusal"]) if data["refusal"] else None
        network = skeleton_of(data["network"])
        self.summary = summary_from(data["network"])
        return network

    def review(self, brain: Side[BrainBackend], network: Network) -> Findings:
        """Return the changes that the backend would make to the last network.

        Raises:
            NrpError: it refuses the network.
        """
        if self._refusal is not None:
            raise self._refusal
        return self._warnings

    def _answer(self, question: str, depends_on: str) -> dict[str, Any]:
        """Return the answer of the child, or a cached one if the environment is the same for the script."""
        for refresh in (False, True):
            answer = run_probe(
                CHILD, question, _cpu_s(self._limit_s), "", depends_on=depends_on, timeout_s=self._limit_s,
                keep_failures=False, refresh=refresh, is_forked=True, has_folder=True,
            )  # fmt: skip
            data = _data(answer, self._limit_s)
            if not have_changed(data["variables"]):
                break
        return data


def build_confined(make: Callable[[], Network], limit_s: float | None) -> Network:
    """Return a complete network that was built in a confined child process.

    Args:
        make: builds it.
        limit_s: time that it may take, s, without that in which others had the processors; None: a day.

    Raises:
        NrpError: the error of ``make``.
    """
    question = _question(make, None, None)
    if question is None:
        return build_here(make)
    limit_s = limit_s or _DAY_S
    with TemporaryDirectory() as folder:
        file = Path(folder) / "network.nrpnet"
        answer = run_module(
            CHILD, question, _cpu_s(limit_s), str(file), timeout_s=limit_s, is_forked=True, has_folder=True
        )
        try:
            _data(answer, limit_s)
        except (SlowScriptError, UncheckedScriptError) as error:
            raise NetworkError(str(error)) from None  # a check can do without the network, the caller cannot
        return read_network(file)


def _question(make: Callable[[], Network], backend: Any, parts: Any) -> str | None:
    """Return the request to a child; None if it depends on objects that exist only in this process."""
    try:
        return base64.b64encode(pickle.dumps((make, backend, parts))).decode()
    except (pickle.PicklingError, AttributeError, TypeError):
        return None


def _cpu_s(limit_s: float) -> str:
    return str(limit_s * cores() + 1)


def _data(answer: ChildResult, limit_s: float) -> dict[str, Any]:
    """Return the data that a child has written.

    Raises:
        NrpError: the error of the script, or the end of its process.
    """
    if answer.exit_code in (None, -getattr(signal, "SIGXCPU", 0) or None):
        raise SlowScriptError(f"the brain script had not built its network after {limit_s:g} s")
    try:
        data: dict[str, Any] = json.loads(answer.output)
    except ValueError:
        raise NetworkError(_how_it_ended(answer)) from None
    if "error" in data:
        raise _error_of(data["error"])
    return data


def _how_it_ended(answer: ChildResult) -> str:
    code, last = answer.exit_code or 0, answer.errors[-300:].strip()
    how = f"by the signal {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
    return f"the brain script ended its process {how}{f': {last}' if last else ', without a message'}"


def _parts(options: BrainOptions | None) -> tuple[type[BrainOptions], dict[str, Any]] | None:
    """Return the values of options in an order that is the same in every process.

    Pydantic's pickles are not, because they have a set of names.
    """
    if options is None:
        return None
    return type(options), {name: getattr(options, name) for name in type(options).model_fields}


def _error_of(error: dict[str, Any]) -> NrpError:
    kind = getattr(errors, error["kind"], NetworkError)
    if issubclass(kind, errors.ExperimentError):
        where = {name: error[name] for name in ("path", "line", "column", "subject")}
        return kind(error["message"], **where)
    made: NrpError = kind(error["message"])
    return made


def _contents(make: Any, backend: BrainBackend | None) -> str:
    """Return a digest of everything that a network depends on: files, and the programs that read them."""
    state = hashlib.blake2b(digest_size=16)
    for value in (*getattr(make, "args", ()), *getattr(make, "keywords", {}).values()):
        if isinstance(value, Path):
            for path in sorted(_reached(value)):
                state.update(f"{path}:{_version(path)};".encode())
    programs = [Path(*nrp_core.brain.__path__), Path(__file__).parent]
    if backend is not None:
        file = sys.modules[type(backend).__module__].__file__
        programs += [Path(file).parent] if file else []
    for folder in programs:
        newest_ns = max((path.stat().st_mtime_ns for path in folder.rglob("*.py")), default=0)
        state.update(f"{folder}:{newest_ns};".encode())
    state.update(f"{version('nrp-core')};{version('PyNN')};{version('numpy')}".encode())
    return state.hexdigest()


def _version(path: Path) -> str:
    """Return a digest of a file's contents; for a large one, its size and time of modification."""
    status = path.stat()
    if status.st_size > _LARGE:
        return f"{status.st_size} {status.st_mtime_ns}"
    try:
        return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()
    except OSError:  # one that only the system can read
        return ""


def _reached(script: Path) -> set[Path]:
    """Return a script, and the modules that it imports and files that it names in its folder."""
    found: set[Path] = set()
    waiting = [script]
    while waiting:
        path = waiting.pop()
        if path in found or not path.is_file():
            continue
        found.add(path)
        if path.suffix == ".py":
            waiting += _named(path)
        elif path.suffix == ".json":  # it describes a network in further files
            found |= {file for file in path.parent.rglob("*") if file.is_file()}
    return found


def _named(script: Path) -> Iterator[Path]:
    try:
        tree = ast.parse(script.read_bytes())
    except (SyntaxError, ValueError):
        return
    for node in ast.walk(tree):
        match node:
            case ast.Import(names):
                yield from (script.parent / f"{alias.name.partition('.')[0]}.py" for alias in names)
            case ast.ImportFrom(module=str(module)):
                yield script.parent / f"{module.partition('.')[0]}.py"
            case ast.Constant(value=str(text)) if 0 < len(text) < 200 and text.isprintable():
                yield script.parent / text
