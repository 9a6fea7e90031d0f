"""Confine this process before it executes other people's code.

It keeps a list of system calls (seccomp): computing, reading files, and writing into some folders, which
Landlock restricts. It has no network, cannot reach other processes, and everything that it starts ends with
it. Linux can do all of this without privileges (Landlock since 5.13, on x86-64 and ARM64), unless an
administrator has switched it off. Where it cannot be done, the code must not be executed.
``python -P -m nrp_core._support.confinement FOLDER`` confines its own process, and prints how.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final, NoReturn

from nrp_core._support.system_calls import allow_own_calls


class _Noting(os._Environ[str]):
    """``os.environ`` that notes the names that are looked up."""

    noted: set[str]

    def __getitem__(self, key: str) -> str:
        if isinstance(key, str):  # starting a process also asks for b"PATH", in vain
            self.noted.add(key)
        value: str = super().__getitem__(key)
        return value

    def __iter__(self) -> Iterator[str]:
        for key in super().__iter__():
            self.noted.add(key)
            yield key


@contextmanager
def noting_variables() -> Iterator[set[str]]:
    """Collect the names of the environment variables that are read in this block, by all threads."""
    os.environ.__class__ = _Noting
    os.environ.noted = set()  # type: ignore[attr-defined]
    try:
        yield os.environ.noted  # type: ignore[attr-defined]
    finally:
        os.environ.__class__ = os._Environ


def values_of(names: set[str]) -> dict[str, str | None]:
    """Return the values of environment variables, None for those that are not set."""
    return {name: os.environ.get(name) for name in sorted(names)}


def have_changed(values: Mapping[str, str | None]) -> bool:
    """Return whether environment variables now have other values."""
    return any(os.environ.get(name) != value for name, value in values.items())


TRUST: Final = "NRP_TRUST"
"""The environment variable of ``--trust``: code is executed without confinement."""
_NEW_USER, _NEW_IPC, _NEW_PROCESSES, _NEW_NETWORK = 0x10000000, 0x08000000, 0x20000000, 0x40000000
_END_WITH_PARENT, _NO_NEW_PRIVILEGES = 1, 38
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446  # the same on every architecture
_VERSION = 1
_BENEATH = 1
_EXECUTE, _WRITE, _READ, _LIST = 1 << 0, 1 << 1, 1 << 2, 1 << 3
_REMOVE_AND_MAKE = sum(1 << bit for bit in range(4, 13))
_REMOVE_AND_MAKE_PLAIN = sum(1 << bit for bit in (4, 5, 7, 8))
"""The same for files and folders only: no links, sockets, pipes and devices."""
_REFER, _TRUNCATE = 1 << 13, 1 << 14
_TRUNCATE_SINCE, _REFER_SINCE = 3, 2
_SCOPES, _SCOPES_SINCE = 0b11, 6
"""Abstract sockets and signals, and the version of Landlock that restricts them."""
_DEVICES = tuple(Path("/dev") / name for name in ("null", "zero", "full"))
_PROCESSES = Path("/proc")
_FACTS = (
    "self",
    "sys",
    "cpuinfo",
    "meminfo",
    "stat",
    "version",
    "uptime",
    "loadavg",
    "filesystems",
    "mounts",
)
"""What may be read below ``/proc``: nothing of other processes."""
_SHARE_OF_MEMORY = 0.8
_ADDRESSES, _ADDRESSES_OF_CORE = 8 << 30, 1 << 30
"""Address space that libraries reserve without using it, bytes."""
_PROCESSES_APART, _PROCESSES_OF_CORE = 64, 4
_COUNTS_APART = (5, 14)
"""The version of Linux since which processes are counted by namespace."""
_CAPABILITY_VERSION, _READ_ALL = 0x20080522, 1 << 2
"""The format of capabilities, and the one to read every file."""
FILE_BYTES = 200_000_000


def is_trusted() -> bool:
    """Return whether the user has said ``--trust``."""
    return os.environ.get(TRUST, "").lower() in ("1", "true", "yes", "on")


@contextmanager
def trusting(is_trusted: bool) -> Iterator[None]:
    """Pass the user's decision to :func:`confine` in child processes that this block starts."""
    before = os.environ.get(TRUST)
    os.environ[TRUST] = str(is_trusted).lower()
    try:
        yield
    finally:
        os.environ.pop(TRUST)
        if before is not None:
            os.environ[TRUST] = before


def confine(*, cpu_s: float, writable: Iterable[Path], file_bytes: int = FILE_BYTES) -> list[str]:
    """Go on in a process that has only the rights that a check of a script needs, with its children.

    Call it while the process has a single thread. Where the system permits namespaces, the caller goes on in
    a new process, and the old one waits for it and ends as it does. With ``--trust`` only the limits apply.

    Args:
        cpu_s: processor time after which the process is ended, s.
        writable: folders in which it may write; the first one becomes that for temporary files.
        file_bytes: the largest size of a file that it may write.

    Returns:
        Measures that the system lacks, without which code of others must not run: ``Landlock``, ``seccomp``.
    """
    folders = list(writable)
    os.environ["TMPDIR"] = tempfile.tempdir = str(folders[0])
    os.environ["HDF5_USE_FILE_LOCKING"] = "FALSE"
    _limit(cpu_s, file_bytes)
    if is_trusted():
        return []
    if not sys.platform.startswith("linux"):
        return ["Landlock", "seccomp"]
    version = _landlock_version()
    if version < 1:
        return ["Landlock"]
    is_apart = _enter_namespaces()
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    _drop_capabilities()
    if not _restrict_files(folders, version):
        return ["Landlock"]
    are_scoped = is_apart or version >= _SCOPES_SINCE
    if not allow_own_calls(signals_are_scoped=are_scoped, truncation_is_scoped=version >= _TRUNCATE_SINCE):
        return ["seccomp"]
    return []


def _limit(cpu_s: float, file_bytes: int) -> None:
    """Limit the processor time, the size of files, and the memory to most of that of the machine."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    addresses = memory + _ADDRESSES + _ADDRESSES_OF_CORE * (os.cpu_count() or 1)
    _set_limit(resource.RLIMIT_CPU, max(1, int(cpu_s)))
    _set_limit(resource.RLIMIT_DATA, int(memory * _SHARE_OF_MEMORY))
    _set_limit(resource.RLIMIT_AS, addresses)
    _set_limit(resource.RLIMIT_FSIZE, file_bytes)
    _set_limit(resource.RLIMIT_CORE, 0)


def _set_limit(kind: int, limit: int) -> None:
    import resource

    with suppress(OSError, ValueError):
        _, hard = resource.getrlimit(kind)
        lowest = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
        resource.setrlimit(kind, (lowest, lowest))


# -- namespaces


def _enter_namespaces() -> bool:
    """Go on as a process of namespaces for processes, network and shared memory; return whether it could."""
    libc = ctypes.CDLL(None, use_errno=True)
    user, group = os.getuid(), os.getgid()
    own = _NEW_PROCESSES | _NEW_NETWORK | _NEW_IPC
    is_user_apart = False
    if libc.unshare(own) != 0:
        if libc.unshare(_NEW_USER | own) != 0:
            return False
        is_user_apart = True
        with suppress(OSError):  # without them the process runs as an unknown user, which does not matter
            Path("/proc/self/setgroups").write_text("deny")
            Path("/proc/self/uid_map").write_text(f"{user} {user} 1")
            Path("/proc/self/gid_map").write_text(f"{group} {group} 1")
    libc.prctl(_END_WITH_PARENT, int(signal.SIGKILL), 0, 0, 0)
    ours, theirs = os.pipe()
    first = os.fork()
    if first:
        os.close(theirs)
        _end_as(first, ours)
    os.close(ours)
    libc.prctl(_END_WITH_PARENT, int(signal.SIGKILL), 0, 0, 0)
    worker = os.fork()
    if worker:
        _reap_until(worker, theirs)
    os.close(theirs)
    if is_user_apart:
        _limit_processes()
    return True


def _end_as(first: int, status: int) -> NoReturn:
    """Wait for the first process of a namespace, and end as the worker there ended."""
    os.waitpid(first, 0)
    written = os.read(status, 8)
    code = os.waitstatus_to_exitcode(int(written)) if written else -int(signal.SIGKILL)
    if code < 0:
        with suppress(OSError, ValueError):
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(abs(code))


def _reap_until(worker: int, status: int) -> NoReturn:
    """Wait for the end of the worker; the system then ends all others of the namespace with this process."""
    while True:
        pid, code = os.wait()
        if pid == worker:
            os.write(status, str(code).encode())
            os._exit(0)


def _limit_processes() -> None:
    """Limit the number of processes and threads, where others of the user do not count."""
    import resource

    release = tuple(int(part) for part in os.uname().release.split(".")[:2] if part.isdigit())
    if release >= _COUNTS_APART:
        _set_limit(resource.RLIMIT_NPROC, _PROCESSES_APART + _PROCESSES_OF_CORE * (os.cpu_count() or 1))


class _Capabilities(ctypes.Structure):
    _fields_ = (("sets", ctypes.c_uint32 * 6),)


def _drop_capabilities() -> None:
    """Give up the rights of the system's administrator, except the one to read files."""
    libc = ctypes.CDLL(None, use_errno=True)
    header = (ctypes.c_uint32 * 2)(_CAPABILITY_VERSION, 0)
    held = _Capabilities()
    libc.capget(header, ctypes.byref(held))
    effective, permitted, *_ = held.sets
    kept = _Capabilities((ctypes.c_uint32 * 6)(effective & _READ_ALL, permitted & _READ_ALL, 0, 0, 0, 0))
    libc.capset(header, ctypes.byref(kept))


# -- files


class _Ruleset(ctypes.Structure):
    _fields_ = (
        ("handled_access_fs", ctypes.c_uint64),
        ("handled_access_net", ctypes.c_uint64),
        ("scoped", ctypes.c_uint64),
    )


class _Beneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("allowed_access", ctypes.c_uint64), ("parent_fd", ctypes.c_int32))


def _landlock_version() -> int:
    """Return the version of Landlock, 0 or less without it."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    return int(libc.syscall(_CREATE_RULESET, None, ctypes.c_size_t(0), ctypes.c_uint32(_VERSION)))


def _restrict_files(folders: list[Path], version: int) -> bool:
    """Forbid by Landlock to write, make and remove files, except in some folders and some devices.

    Files of other processes below ``/proc`` cannot be read either. From version 6 on, abstract sockets and
    signals of other processes are forbidden, too.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    extra = (_REFER if version >= _REFER_SINCE else 0) | (_TRUNCATE if version >= _TRUNCATE_SINCE else 0)
    reading = _EXECUTE | _READ | _LIST
    rules = _Ruleset(
        reading | _WRITE | _REMOVE_AND_MAKE | extra, 0, _SCOPES if version >= _SCOPES_SINCE else 0
    )
    size = ctypes.sizeof(rules) if version >= _SCOPES_SINCE else 8
    ruleset = libc.syscall(_CREATE_RULESET, ctypes.byref(rules), ctypes.c_size_t(size), ctypes.c_uint32(0))
    if ruleset < 0:
        return False
    roots = [path for path in Path("/").iterdir() if path != _PROCESSES]
    granted = (
        ([*roots, *(_PROCESSES / name for name in _FACTS)], reading),
        (folders, reading | _WRITE | _REMOVE_AND_MAKE_PLAIN | extra),
        (_DEVICES, _READ | _WRITE | extra & _TRUNCATE),
    )
    try:
        for paths, rights in granted:
            for handle, of_kind in _opened(paths):
                rule = _Beneath(rights & of_kind, handle)
                libc.syscall(_ADD_RULE, ruleset, _BENEATH, ctypes.byref(rule), ctypes.c_uint32(0))
        return bool(libc.syscall(_RESTRICT_SELF, ruleset, ctypes.c_uint32(0)) == 0)
    finally:
        os.close(ruleset)


def _opened(paths: Iterable[Path]) -> Iterator[tuple[int, int]]:
    """Yield a handle of each path that exists, and the rights that its kind of file can have."""
    for path in paths:
        with suppress(OSError):
            is_folder = path.is_dir()
            handle = os.open(path, os.O_PATH | os.O_CLOEXEC)
            try:
                yield handle, (1 << 15) - 1 if is_folder else _EXECUTE | _READ | _WRITE | _TRUNCATE
            finally:
                os.close(handle)


def _report(folder: Path) -> int:
    """Confine this process, print how, and return the number of measures that the system lacks."""
    os.environ.pop(TRUST, None)
    lacking = confine(cpu_s=60.0, writable=[folder])
    if lacking:
        print(f"{' and '.join(lacking)} cannot be used")
    else:
        ends = "a namespace" if os.getppid() == 1 else "their group"
        print(f"a list of system calls, files by Landlock, processes end with {ends}")
    return len(lacking)


if __name__ == "__main__":
    sys.exit(_report(Path(sys.argv[1])))
