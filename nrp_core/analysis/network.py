"""What a network is, without building it in this process.

A brain script is the one piece of user code that has to be executed to know what it says. It runs in a child
process with a time limit, and its answer is kept for as long as the script, what it imports, and the
programs that read it stay the same.
"""

from __future__ import annotations

import ast
import base64
import hashlib
import json
import pickle
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import nrp_core.brain
from nrp_core import errors
from nrp_core._support.probe import inquire
from nrp_core.analysis.skeleton import skeleton_of
from nrp_core.brain.interface import BrainBackend, BrainOptions
from nrp_core.brain.network.data import Network
from nrp_core.errors import NetworkError, NrpError, SlowScriptError
from nrp_core.experiment.making.maker import build_here

TIME_LIMIT_S = 20.0
_LARGE = 10_000_000
CHILD = "nrp_core.analysis.child"


class ChildBuilder:
    """Builds networks in a child process.

    Args:
        backend: is asked what it would not keep of the network; None: nobody is.
        options: its options.

    Attributes:
        warnings: what the backend said of the last network.
        refusal: why it would not take it at all.
    """

    def __init__(self, backend: BrainBackend | None, options: BrainOptions | None) -> None:
        self._backend, self._options = backend, options
        self.warnings: list[str] = []
        self.refusal: NrpError | None = None

    def __call__(self, make: Callable[[], Network]) -> Network:
        """Return a network without synapses, parameters and positions that is like the one to be made.

        Raises:
            NrpError: what ``make`` raises.
        """
        try:
            question = pickle.dumps((make, self._backend, _parts(self._options)))
        except (pickle.PicklingError, AttributeError, TypeError):  # made of what lives in this process only
            return build_here(make)
        answer = inquire(
            CHILD, base64.b64encode(question).decode(), depends_on=_contents(make, self._backend),
            timeout_s=TIME_LIMIT_S, keep_failures=False,
        )  # fmt: skip
        if answer.exit_code is None:
            raise SlowScriptError(f"it had not built its network after {TIME_LIMIT_S:g} s")
        try:
            told = json.loads(answer.output)
        except ValueError:
            raise NetworkError(f"it ended the process that read it: {answer.errors[-300:].strip()}") from None
        if "error" in told:
            raise _error_of(told["error"])
        self.warnings = told["warnings"]
        self.refusal = _error_of(told["refusal"]) if told["refusal"] else None
        return skeleton_of(told["network"])


def _parts(options: BrainOptions | None) -> tuple[type[BrainOptions], dict[str, Any]] | None:
    """Return what options are made of, in an order that is the same in every process.

    What pydantic pickles is not: it keeps a set of names.
    """
    if options is None:
        return None
    return type(options), {name: getattr(options, name) for name in type(options).model_fields}


def _error_of(told: dict[str, Any]) -> NrpError:
    kind = getattr(errors, told["kind"], NetworkError)
    if issubclass(kind, errors.ExperimentError):
        return kind(told["message"], path=told["path"], line=told["line"], column=told["column"])
    made: NrpError = kind(told["message"])
    return made


def _contents(make: Any, backend: BrainBackend | None) -> str:
    """Return a digest of all that a network depends on: files, and the programs that read them."""
    state = hashlib.blake2b(digest_size=16)
    for value in (*getattr(make, "args", ()), *getattr(make, "keywords", {}).values()):
        if isinstance(value, Path):
            for path in sorted(_reached(value)):
                state.update(f"{path}:{_version(path)};".encode())
    programs = [Path(*nrp_core.brain.__path__)]
    if backend is not None:
        file = sys.modules[type(backend).__module__].__file__
        programs += [Path(file).parent] if file else []
    for folder in programs:
        newest_ns = max((path.stat().st_mtime_ns for path in folder.rglob("*.py")), default=0)
        state.update(f"{folder}:{newest_ns};".encode())
    state.update(f"{version('nrp-core')};{version('PyNN')};{version('numpy')}".encode())
    return state.hexdigest()


def _version(path: Path) -> str:
    """Return what changes with the contents of a file; of a large one, when it was written."""
    told = path.stat()
    if told.st_size > _LARGE:
        return f"{told.st_size} {told.st_mtime_ns}"
    return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()


def _reached(script: Path) -> set[Path]:
    """Return a script, the modules that it imports from beside it, and the files that it names there."""
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
