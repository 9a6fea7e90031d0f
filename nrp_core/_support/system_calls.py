"""Allow this process a list of system calls, by seccomp; all others fail.

A filter is a program for the kernel's packet filter (``man 2 seccomp``). The numbers are those in the
kernel's tables of x86-64 and ARM64. Not in the list are the calls for sockets, other processes, namespaces,
shared memory, and modes, owners, times, attributes and locks of files.
"""

from __future__ import annotations

import ctypes
import os
import platform
from collections.abc import Iterator
from errno import ENOSYS, EPERM
from typing import Final, NamedTuple

_LOAD, _MASK, _EQUAL, _AT_LEAST, _RETURN = 0x20, 0x54, 0x15, 0x35, 0x06
_NUMBER, _ARCHITECTURE, _FIRST_ARGUMENT = 0, 4, 16  # offsets in struct seccomp_data, little endian
_ALLOW, _ERROR = 0x7FFF0000, 0x00050000
_SET_SECCOMP, _MODE_FILTER = 22, 2
_X32 = 0x40000000
"""From this number on, x86-64 has a second table."""
_NEW = 424
"""From this number on, the tables are the same, and the C library tries calls that a kernel may lack."""


class _Calls(NamedTuple):
    """Numbers of system calls.

    Args:
        audit: the name of the architecture for filters.
        allowed: those that are allowed with all arguments: of files and folders, of waiting, of the own
            memory and signals, of starting and awaiting children, and of facts about this process.
        clone, kill, tgkill, fcntl, ioctl, prctl, prlimit, affinity, flock, open, openat, pair: those whose
            arguments matter; -1 if the architecture lacks one.
    """

    audit: int
    allowed: tuple[int, ...]
    clone: int
    kill: int
    tgkill: int
    fcntl: int
    ioctl: int
    prctl: int
    prlimit: int
    affinity: int
    flock: int
    open: int
    openat: int
    pair: int


_X86_64: Final = (
    # files and folders
    0, 1, 3, 4, 5, 6, 8, 17, 18, 19, 20, 21, 22, 32, 33, 40, 74, 75, 77, 78, 79, 80, 81, 82, 83, 84, 85,
    87, 89, 95, 137, 138, 187, 217, 221, 258, 262, 263, 264, 267, 269, 277, 285, 292, 293, 295, 296,
    316, 326, 327, 328, 332, 436, 439,
    # the ends of a connected pair
    44, 45, 48,
    # waiting
    7, 23, 34, 35, 36, 37, 38, 213, 219, 222, 223, 224, 225, 226, 230, 232, 233, 270, 271, 281, 283,
    284, 286, 287, 290, 291, 441,
    # memory, signals
    9, 10, 11, 12, 25, 26, 27, 28, 149, 150, 237, 238, 239, 324, 329, 330, 331, 13, 14, 15, 127, 128,
    130, 131, 282, 289,
    # processes
    24, 57, 58, 59, 60, 61, 158, 202, 218, 231, 247, 273, 309, 334, 449,
    # facts
    39, 63, 96, 97, 98, 99, 100, 102, 104, 107, 108, 110, 111, 115, 118, 120, 121, 124, 125, 140, 143,
    145, 146, 147, 160, 186, 201, 204, 228, 229, 318,
)  # fmt: skip
_ARM64: Final = (
    # files and folders
    17, 23, 24, 34, 35, 38, 43, 44, 46, 47, 48, 49, 50, 57, 59, 61, 62, 63, 64, 65, 66, 67, 68, 69, 70,
    71, 78, 79, 80, 82, 83, 84, 166, 213, 223, 276, 285, 286, 287, 291, 436, 439,
    # the ends of a connected pair
    206, 207, 210,
    # waiting
    19, 20, 21, 22, 72, 73, 85, 86, 87, 101, 102, 103, 107, 108, 109, 110, 111, 115, 128, 441,
    # memory, signals
    214, 215, 216, 222, 226, 227, 228, 229, 232, 233, 235, 236, 237, 283, 288, 289, 290, 74, 132, 133,
    134, 135, 136, 137, 139,
    # processes
    93, 94, 95, 96, 98, 99, 124, 168, 221, 260, 293, 449,
    # facts
    90, 113, 114, 120, 121, 123, 125, 126, 141, 148, 150, 153, 155, 156, 158, 160, 163, 164, 165, 169,
    172, 173, 174, 175, 176, 177, 178, 179, 278,
)  # fmt: skip
_TABLES: Final = {
    "x86_64": _Calls(0xC000003E, _X86_64, 56, 62, 234, 72, 16, 157, 302, 203, 73, 2, 257, 53),
    "aarch64": _Calls(0xC00000B7, _ARM64, 220, 129, 131, 25, 29, 167, 261, 122, 32, -1, 56, 199),
}
_NAMESPACES: Final = 0x7E028000
"""Flags of clone that make namespaces, or a sibling instead of a child."""
_ALL: Final = 0xFFFFFFFF
_COPIES_AND_FLAGS: Final = (0, 1, 2, 3, 4, 1030, 1031, 1032)
"""Commands of fcntl: not those of locks, owners, leases and notifications."""
_TERMINAL_FACTS: Final = (0x5401, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)
"""Requests of ioctl: the settings and size of a terminal, what can be read, and flags of a descriptor."""
_OWN_SETTINGS: Final = (1, 3, 15, 16, 0x53564D41)
"""Options of prctl: the signal at the end of the parent, and names of threads and memory."""
_KIND_OF_SOCKET, _STREAM = 0xF, 1
"""Datagrams of a pair can be sent elsewhere, a stream cannot."""
_ACCESS_AND_TRUNCATE, _TRUNCATE = 0o1003, 0o1000


class _Instruction(ctypes.Structure):
    _fields_ = (
        ("code", ctypes.c_uint16),
        ("jt", ctypes.c_uint8),
        ("jf", ctypes.c_uint8),
        ("k", ctypes.c_uint32),
    )


class _Program(ctypes.Structure):
    _fields_ = (("length", ctypes.c_ushort), ("instructions", ctypes.POINTER(_Instruction)))


class _Rule(NamedTuple):
    """A call that is decided by one argument.

    Args:
        number: the call.
        argument: the index of the argument.
        mask: its bits that matter.
        values: their values.
        is_allowed: whether these values are allowed and all others not, or the other way round.
    """

    number: int
    argument: int
    mask: int
    values: tuple[int, ...]
    is_allowed: bool = True


def allow_own_calls(*, signals_are_scoped: bool, truncation_is_scoped: bool) -> bool:
    """Forbid all system calls but those of a computation in this process and its children.

    Call it after ``no_new_privs`` is set, in the only thread.

    Args:
        signals_are_scoped: whether something else restricts signals to this process and its children; if not,
            this process can only signal itself.
        truncation_is_scoped: whether something else forbids to empty files that may only be read.

    Returns:
        whether the system could do it.
    """
    calls = _TABLES.get(platform.machine())
    if calls is None:
        return False
    instructions = list(_filter(calls, _rules(calls, signals_are_scoped, truncation_is_scoped)))
    program = _Program(len(instructions), (_Instruction * len(instructions))(*instructions))
    libc = ctypes.CDLL(None, use_errno=True)
    return bool(libc.prctl(_SET_SECCOMP, _MODE_FILTER, ctypes.byref(program), 0, 0) == 0)


def _rules(calls: _Calls, signals_are_scoped: bool, truncation_is_scoped: bool) -> list[_Rule]:
    own: tuple[int, ...] = (os.getpid(),)
    nobody: tuple[int, ...] = ()
    rules = [
        _Rule(calls.clone, 0, _NAMESPACES, (0,)),
        _Rule(calls.fcntl, 1, _ALL, _COPIES_AND_FLAGS),
        _Rule(calls.ioctl, 1, _ALL, _TERMINAL_FACTS),
        _Rule(calls.prctl, 0, _ALL, _OWN_SETTINGS),
        _Rule(calls.prlimit, 0, _ALL, (0,)),
        _Rule(calls.affinity, 0, _ALL, (0,)),
        _Rule(calls.pair, 1, _KIND_OF_SOCKET, (_STREAM,)),
    ]
    signalled = nobody if signals_are_scoped else own
    rules += [
        _Rule(call, 0, _ALL, signalled, is_allowed=not signals_are_scoped)
        for call in (calls.kill, calls.tgkill)
    ]
    emptied = nobody if truncation_is_scoped else (_TRUNCATE,)
    rules += [
        _Rule(call, flags, _ACCESS_AND_TRUNCATE, emptied, is_allowed=False)
        for call, flags in ((calls.open, 1), (calls.openat, 2))
    ]
    return [rule for rule in rules if rule.number >= 0]


def _filter(calls: _Calls, rules: list[_Rule]) -> Iterator[_Instruction]:
    """Yield the instructions of a filter."""
    allow, refuse = _Instruction(_RETURN, 0, 0, _ALLOW), _Instruction(_RETURN, 0, 0, _ERROR | EPERM)
    lack = _Instruction(_RETURN, 0, 0, _ERROR | ENOSYS)
    yield _Instruction(_LOAD, 0, 0, _ARCHITECTURE)
    yield from (_Instruction(_EQUAL, 1, 0, calls.audit), refuse)
    yield _Instruction(_LOAD, 0, 0, _NUMBER)
    yield from (_Instruction(_AT_LEAST, 0, 1, _X32), refuse)
    for number in calls.allowed:
        yield from (_Instruction(_EQUAL, 0, 1, number), allow)
    for rule in rules:
        yield _Instruction(_EQUAL, 0, 3 + 2 * len(rule.values), rule.number)
        yield _Instruction(_LOAD, 0, 0, _FIRST_ARGUMENT + 8 * rule.argument)
        yield _Instruction(_MASK, 0, 0, rule.mask)
        for value in rule.values:
            yield from (_Instruction(_EQUAL, 0, 1, value), allow if rule.is_allowed else refuse)
        yield refuse if rule.is_allowed else allow
    # HDF5 does without locks, and the C library without new calls, if the system lacks them
    yield from (_Instruction(_EQUAL, 0, 1, calls.flock), lack)
    yield from (_Instruction(_AT_LEAST, 0, 1, _NEW), lack)
    yield refuse
