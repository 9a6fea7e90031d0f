"""Deny this process the system calls that reach other processes, by seccomp.

A filter is a program for the kernel's packet filter (``man 2 seccomp``). The numbers of the calls are those
in the kernel's tables of x86-64 and ARM64.
"""

from __future__ import annotations

import ctypes
import os
import platform
from errno import EACCES, EPERM
from typing import Final, NamedTuple

_LOAD, _EQUAL, _AT_LEAST, _RETURN = 0x20, 0x15, 0x35, 0x06
_NUMBER, _ARCHITECTURE, _FIRST_ARGUMENT = 0, 4, 16  # offsets in struct seccomp_data, little endian
_ALLOW, _ERROR = 0x7FFF0000, 0x00050000
_SET_SECCOMP, _MODE_FILTER = 22, 2
_UNIX: Final = 1
"""The family of sockets in the file system, AF_UNIX."""
_X32 = 0x40000000
"""From this number on, x86-64 has a second table."""


class _Table(NamedTuple):
    """Numbers of system calls.

    Args:
        audit: the name of the architecture for filters.
        socket: the call that makes a socket.
        signals: calls whose first argument is the process that gets a signal.
        denied: calls that read, change or signal other processes, or make calls past the filter (io_uring).
    """

    audit: int
    socket: int
    signals: tuple[int, ...]
    denied: tuple[int, ...]


# kill and tgkill; ptrace, process_vm_readv, process_vm_writev, tkill, rt_sigqueueinfo, rt_tgsigqueueinfo,
# pidfd_send_signal, io_uring_setup, pidfd_getfd
_TABLES: Final = {
    "x86_64": _Table(0xC000003E, 41, (62, 234), (101, 310, 311, 200, 129, 297, 424, 425, 438)),
    "aarch64": _Table(0xC00000B7, 198, (129, 131), (117, 270, 271, 130, 138, 240, 424, 425, 438)),
}


class _Instruction(ctypes.Structure):
    _fields_ = (
        ("code", ctypes.c_uint16),
        ("jt", ctypes.c_uint8),
        ("jf", ctypes.c_uint8),
        ("k", ctypes.c_uint32),
    )


class _Program(ctypes.Structure):
    _fields_ = (("length", ctypes.c_ushort), ("instructions", ctypes.POINTER(_Instruction)))


def leave_other_processes(*, signals_are_scoped: bool) -> bool:
    """Forbid sockets in the file system, and reading, changing and signalling other processes.

    Pairs of connected sockets can still be made. Call it after ``no_new_privs`` is set, in the only thread.

    Args:
        signals_are_scoped: whether something else restricts signals to this process and its children; if not,
            this process can only signal itself.

    Returns:
        whether the system could do it.
    """
    table = _TABLES.get(platform.machine())
    if table is None:
        return False
    rules: list[tuple[int, int | None, int]] = [(number, None, EPERM) for number in table.denied]
    if not signals_are_scoped:
        rules += [(number, os.getpid(), EPERM) for number in table.signals]
    instructions = _filter(table, rules)
    program = _Program(len(instructions), (_Instruction * len(instructions))(*instructions))
    libc = ctypes.CDLL(None, use_errno=True)
    return bool(libc.prctl(_SET_SECCOMP, _MODE_FILTER, ctypes.byref(program), 0, 0) == 0)


def _filter(table: _Table, rules: list[tuple[int, int | None, int]]) -> list[_Instruction]:
    """Return a filter.

    Args:
        table: the numbers of calls.
        rules: for each call its number, the only first argument that is allowed, and the error otherwise.
    """

    def fail(error: int) -> _Instruction:
        return _Instruction(_RETURN, 0, 0, _ERROR | error)

    allow = _Instruction(_RETURN, 0, 0, _ALLOW)
    made = [
        _Instruction(_LOAD, 0, 0, _ARCHITECTURE),
        _Instruction(_EQUAL, 1, 0, table.audit),
        fail(EPERM),
        _Instruction(_LOAD, 0, 0, _NUMBER),
        _Instruction(_AT_LEAST, 0, 1, _X32),
        fail(EPERM),
    ]
    for number, allowed, error in rules:
        if allowed is None:
            made += [_Instruction(_EQUAL, 0, 1, number), fail(error)]
        else:
            first = _Instruction(_LOAD, 0, 0, _FIRST_ARGUMENT)
            made += [_Instruction(_EQUAL, 0, 4, number), first]
            made += [_Instruction(_EQUAL, 0, 1, allowed), allow, fail(error)]
    first = _Instruction(_LOAD, 0, 0, _FIRST_ARGUMENT)
    made += [_Instruction(_EQUAL, 0, 3, table.socket), first]
    return [*made, _Instruction(_EQUAL, 0, 1, _UNIX), fail(EACCES), allow]
