"""Confine this process before it executes other people's code.

It loses the network, sockets in the file system, other processes, and writing outside some folders; processor
time and memory are limited. Linux can do it without privileges (namespaces since 3.8, Landlock since 5.13,
seccomp since 3.5), unless an administrator has switched that off. Elsewhere only the limits hold.
``python -m nrp_core._support.confinement FOLDER`` confines its own process and fails if that is incomplete.
"""

from __future__ import annotations

import ctypes
import os
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from nrp_core._support.system_calls import leave_other_processes


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


_NEW_USER, _NEW_NETWORK = 0x10000000, 0x40000000
_NO_NEW_PRIVILEGES = 38
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446  # the same on every architecture
_VERSION = 1
_BENEATH = 1
_WRITE = 1 << 1
_REMOVE_AND_MAKE = sum(1 << bit for bit in range(4, 13))
_REFER, _TRUNCATE = 1 << 13, 1 << 14  # since versions 2 and 3
_SCOPES, _SCOPES_SINCE = 0b11, 6
"""Abstract sockets and signals, and the version of Landlock that restricts them."""
_DEVICES = tuple(Path("/dev") / name for name in ("null", "zero", "full", "tty"))
_SHARE_OF_MEMORY = 0.8


def confine(*, cpu_s: float, writable: Iterable[Path]) -> list[str]:
    """Restrict this process and its children to the rights that a check of a script needs.

    Call it while the process has a single thread.

    Args:
        cpu_s: processor time after which the process is ended, s.
        writable: folders in which it may write; the first one becomes that for temporary files.

    Returns:
        The rights that the system does not let it give up: ``network``, ``files``, ``processes``, ``limits``.
    """
    folders = list(writable)
    os.environ["TMPDIR"] = tempfile.tempdir = str(folders[0])
    has_left_network, version = _leave_network(), _landlock_version()
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    rights = {
        "network": has_left_network,
        "files": _write_only_in(folders, version),
        "processes": sys.platform.startswith("linux")
        and leave_other_processes(signals_are_scoped=version >= _SCOPES_SINCE),
        "limits": _limit(cpu_s),
    }
    return [name for name, is_left in rights.items() if not is_left]


def _limit(cpu_s: float) -> bool:
    """Limit the processor time, and the memory to most of that of the machine."""
    try:
        import resource
    except ImportError:  # not on Windows
        return False
    memory = int(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") * _SHARE_OF_MEMORY)
    wanted = {resource.RLIMIT_CPU: max(1, int(cpu_s)), resource.RLIMIT_DATA: memory, resource.RLIMIT_CORE: 0}
    try:
        for kind, limit in wanted.items():
            _, hard = resource.getrlimit(kind)
            lowest = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
            resource.setrlimit(kind, (lowest, lowest))
    except (OSError, ValueError):
        return False
    return True


def _leave_network() -> bool:
    """Move into a network without devices."""
    if not sys.platform.startswith("linux"):
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    user, group = os.getuid(), os.getgid()
    if libc.unshare(_NEW_NETWORK) == 0:
        return True
    if libc.unshare(_NEW_USER | _NEW_NETWORK) != 0:
        return False
    with suppress(OSError):  # without them the process runs as nobody, which does not matter
        Path("/proc/self/setgroups").write_text("deny")
        Path("/proc/self/uid_map").write_text(f"{user} {user} 1")
        Path("/proc/self/gid_map").write_text(f"{group} {group} 1")
    return True


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
    if not sys.platform.startswith("linux"):
        return 0
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    return int(libc.syscall(_CREATE_RULESET, None, ctypes.c_size_t(0), ctypes.c_uint32(_VERSION)))


def _write_only_in(folders: Iterable[Path], version: int) -> bool:
    """Forbid by Landlock to write, make and remove files, except in some folders and some devices.

    From version 6 on, abstract sockets and signals of other processes are forbidden, too.
    """
    if version < 1:
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    access = _WRITE | _REMOVE_AND_MAKE | (_REFER if version > 1 else 0) | (_TRUNCATE if version > 2 else 0)
    rules = _Ruleset(access, 0, _SCOPES if version >= _SCOPES_SINCE else 0)
    size = ctypes.sizeof(rules) if version >= _SCOPES_SINCE else 8
    ruleset = libc.syscall(_CREATE_RULESET, ctypes.byref(rules), ctypes.c_size_t(size), ctypes.c_uint32(0))
    if ruleset < 0:
        return False
    to_files = access & (_WRITE | _TRUNCATE)
    try:
        for paths, rights in ((folders, access), (_DEVICES, to_files)):
            for handle in _opened(paths):
                rule = _Beneath(rights, handle)
                libc.syscall(_ADD_RULE, ruleset, _BENEATH, ctypes.byref(rule), ctypes.c_uint32(0))
        return bool(libc.syscall(_RESTRICT_SELF, ruleset, ctypes.c_uint32(0)) == 0)
    finally:
        os.close(ruleset)


def _opened(paths: Iterable[Path]) -> Iterator[int]:
    for path in paths:
        with suppress(OSError):
            handle = os.open(path, os.O_PATH | os.O_CLOEXEC)
            try:
                yield handle
            finally:
                os.close(handle)


if __name__ == "__main__":
    left = confine(cpu_s=60.0, writable=[Path(sys.argv[1])])
    print(", ".join(left))
    sys.exit(len(left))
