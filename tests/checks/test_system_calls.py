"""The numbers of system calls that the sandbox allows, against the tables of libseccomp."""

from __future__ import annotations

import ctypes

import pytest

from nrp_core._support.system_calls import _TABLES

OLD = {
    "access", "alarm", "arch_prctl", "creat", "dup2", "epoll_create", "epoll_wait", "eventfd", "fork",
    "getdents", "getpgrp", "lstat", "mkdir", "pause", "pipe", "poll", "readlink", "rename", "rmdir", "select",
    "signalfd", "stat", "time", "unlink", "vfork",
}  # fmt: skip
"""Calls that ARM64 never had; its C library uses others, which both tables have."""
BY_ARGUMENT = (
    "clone", "kill", "tgkill", "fcntl", "ioctl", "prctl", "prlimit64", "sched_setaffinity", "flock", "open",
    "openat", "socketpair",
)  # fmt: skip
"""The calls that are decided by their arguments, in the order of the table."""
REFUSED = (
    "socket", "connect", "bind", "listen", "ptrace", "process_vm_writev", "setns", "unshare", "mount", "bpf",
    "chmod", "fchmodat", "fchownat", "utimensat", "setxattr", "shmget", "keyctl", "pidfd_send_signal",
    "io_uring_setup", "perf_event_open", "reboot", "kexec_load", "init_module", "setpriority", "userfaultfd",
)  # fmt: skip


@pytest.fixture(scope="module")
def libseccomp() -> ctypes.CDLL:
    try:
        library = ctypes.CDLL("libseccomp.so.2")
    except OSError:
        pytest.skip("libseccomp is not installed")
    library.seccomp_syscall_resolve_num_arch.restype = ctypes.c_void_p
    return library


def names(libseccomp: ctypes.CDLL, machine: str, numbers: tuple[int, ...]) -> list[str]:
    """Return the name of each number on a machine; an empty one for a number that it does not have."""
    resolve, architecture = (
        libseccomp.seccomp_syscall_resolve_num_arch,
        ctypes.c_uint32(_TABLES[machine].audit),
    )
    found = [resolve(architecture, number) for number in numbers]
    return ["" if one is None else (ctypes.cast(one, ctypes.c_char_p).value or b"").decode() for one in found]


@pytest.mark.parametrize("machine", _TABLES)
def test_each_number_is_a_call_of_the_machine_and_listed_once(libseccomp: ctypes.CDLL, machine: str) -> None:
    allowed = names(libseccomp, machine, _TABLES[machine].allowed)
    assert "" not in allowed
    assert len(set(allowed)) == len(allowed)
    assert not set(allowed) & {*REFUSED, *BY_ARGUMENT}


def test_both_machines_allow_the_same_calls(libseccomp: ctypes.CDLL) -> None:
    x86_64, arm64 = (set(names(libseccomp, one, _TABLES[one].allowed)) for one in ("x86_64", "aarch64"))
    assert arm64 == x86_64 - OLD
    assert x86_64 >= OLD


@pytest.mark.parametrize("machine", _TABLES)
def test_the_calls_that_are_decided_by_their_arguments_have_the_right_numbers(
    libseccomp: ctypes.CDLL, machine: str
) -> None:
    _, _, *numbers = _TABLES[machine]
    found = names(libseccomp, machine, tuple(numbers))
    assert found == [name if number >= 0 else "" for name, number in zip(BY_ARGUMENT, numbers, strict=True)]
    assert (machine == "aarch64") == (_TABLES[machine].open == -1)
