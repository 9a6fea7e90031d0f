"""Checks of this machine that run in a child process, because they may crash it.

Some graphics libraries abort the process that tries them. A result is kept in the user's cache under a key of
everything it depends on.
"""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from nrp_core._support.cache import cache_root, mark_used
from nrp_core._support.forked import Forker, ends_within

LIBRARIES = Path("/etc/ld.so.cache")
"""Files that change when a system library is installed or removed."""
_FORKER = Forker()


@dataclass(frozen=True, slots=True)
class ChildResult:
    """How a child process ended.

    Args:
        exit_code: the exit code; negative for the signal that killed it, None if it hit the time limit.
        output: its standard output.
        errors: the end of its standard error.
    """

    exit_code: int | None
    output: str = ""
    errors: str = ""


def run_module(
    module: str, *arguments: str, timeout_s: float, is_forked: bool = False, has_folder: bool = False
) -> ChildResult:
    """Run ``python -P -m module arguments...`` in a child process; the answer is not kept.

    ``is_forked`` and ``has_folder`` are those of :func:`run_probe`.
    """
    return _run(_command(module, arguments), timeout_s, is_forked, has_folder)


def run_probe(
    module: str,
    *arguments: str,
    depends_on: str = "",
    timeout_s: float = 30.0,
    refresh: bool = False,
    keep_failures: bool = True,
    is_forked: bool = False,
    has_folder: bool = False,
) -> ChildResult:
    """Run ``python -P -m module arguments...`` in a child process and return how it ended.

    Args:
        module: the module that makes the check.
        arguments: passed to it.
        depends_on: the dependencies of the result, such as versions; another text repeats the check.
            The interpreter, the module and the installed system libraries are always part of it.
        timeout_s: after this time the child, and whatever it started, is ended; time in which it had no
            processor does not count.
        refresh: ignore a cached result.
        keep_failures: whether to keep the result of a child that failed.
        is_forked: whether the module may be run as :mod:`nrp_core._support.forked` does.
        has_folder: whether its last argument is a temporary folder of its own, which is removed when it ends.
    """
    question = _command(module, arguments)
    digest = _digest([*question, sys.version, _modification_time(module), _libraries(), depends_on])
    kept = cache_root() / "probes" / f"{digest}.json"
    if not refresh:
        # not checked yet, or by an older version
        with suppress(OSError, ValueError, KeyError, TypeError):
            answer = ChildResult(**json.loads(kept.read_text())["answer"])
            mark_used(kept)
            return answer
    answer = _run(question, timeout_s, is_forked, has_folder)
    if keep_failures or answer.exit_code == 0:
        _store(kept, {"question": question[1:], "answer": asdict(answer)})
    return answer


def _command(module: str, arguments: Iterable[str]) -> list[str]:
    """Return a command in which modules of the working directory do not replace those of Python."""
    return [sys.executable, "-P", "-m", module, *arguments]


def _run(command: list[str], timeout_s: float, is_forked: bool, has_folder: bool) -> ChildResult:
    if not has_folder:
        return _run_command(command, timeout_s, is_forked)
    with TemporaryDirectory(prefix="nrp-", ignore_cleanup_errors=True) as folder:
        return _run_command([*command, folder], timeout_s, is_forked)


def _run_command(command: list[str], timeout_s: float, is_forked: bool) -> ChildResult:
    can_fork = is_forked and hasattr(os, "fork")  # not on Windows
    if can_fork and (done := _FORKER.run(command[3], command[4:], timeout_s)) is not None:
        return ChildResult(done.exit_code, done.output, done.errors[-2000:])
    pipe = subprocess.PIPE
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, text=True, errors="replace",
        start_new_session=True,
    ) as child:  # fmt: skip
        ended: list[tuple[str, str]] = []

        def wait(for_s: float) -> bool:
            with suppress(subprocess.TimeoutExpired):
                ended.append(child.communicate(timeout=for_s))
            return bool(ended)

        if not ends_within(timeout_s, child.pid, wait):
            _end_group(child)
            child.communicate()
            return ChildResult(None)
        _end_group(child)  # its leftover children, if it is confined
        ((output, errors),) = ended
        return ChildResult(child.returncode, output, errors[-2000:])


def _end_group(child: subprocess.Popen[str]) -> None:
    """End a child and the processes that it started; on Windows, only the child."""
    if not hasattr(os, "killpg"):
        child.kill()
        return
    with suppress(ProcessLookupError):
        os.killpg(child.pid, signal.SIGKILL)


def _store(path: Path, answer: dict[str, object]) -> None:
    """Write the result atomically; without a writable cache the check is repeated next time."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        draft = path.with_suffix(f".{os.getpid()}")
        draft.write_text(json.dumps(answer))
        draft.replace(path)
    except OSError:
        pass


def _modification_time(module: str) -> str:
    """Return the modification time of a module's file."""
    spec = find_spec(module)
    if spec is None or spec.origin is None:
        return ""
    return str(Path(spec.origin).stat().st_mtime_ns)


def _libraries() -> str:
    changed_ns = LIBRARIES.stat().st_mtime_ns if LIBRARIES.exists() else 0
    return f"{changed_ns}:{os.environ.get('LD_LIBRARY_PATH', '')}"


def _digest(texts: list[str]) -> str:
    return hashlib.blake2b("\n".join(texts).encode(), digest_size=16).hexdigest()
