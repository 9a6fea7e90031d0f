"""Attempts of a script to reach beyond its process: a program that confines itself and tries them all.

``python -P attempts.py SCRATCH OUTSIDE VICTIM PORT SHARED`` prints what came of each, in JSON.
"""

import ctypes
import fcntl
import json
import mmap
import os
import resource
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nrp_core._support.confinement import confine

SCRATCH, OUTSIDE, VICTIM, PORT, SHARED = (
    Path(sys.argv[1]), Path(sys.argv[2]), *(int(word) for word in sys.argv[3:6])
)  # fmt: skip
KEPT = str(OUTSIDE / "kept")
LIBC = ctypes.CDLL(None, use_errno=True)
X86 = os.uname().machine == "x86_64"
FAMILIES = (
    "AF_INET", "AF_INET6", "AF_UNIX", "AF_VSOCK", "AF_NETLINK", "AF_ALG", "AF_PACKET", "AF_CAN", "AF_TIPC",
    "AF_BLUETOOTH", "AF_QIPCRTR", "AF_RDS",
)  # fmt: skip


def called(result: int) -> int:
    """Return the result of a function of the C library; raise its error."""
    if result < 0 or result == 2**64 - 1:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result


def system(x86: int, arm: int, *arguments: Any) -> int:
    """Make a system call by its number."""
    LIBC.syscall.restype = ctypes.c_long
    return called(LIBC.syscall(x86 if X86 else arm, *arguments))


def succeeds(*command: str) -> None:
    """Run a command; raise an error if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise OSError(done.stderr)


def truncate_for_reading() -> None:
    os.close(os.open(KEPT, os.O_RDONLY | os.O_TRUNC))


def write_through(name: str, make: Callable[[str, str], None]) -> None:
    place = str(SCRATCH / name)
    make(KEPT, place)
    Path(place).write_text("changed")


def change_flags() -> None:
    with open(KEPT) as file:
        fcntl.ioctl(file, 0x40086602, struct.pack("l", 0x80))


def send_pair() -> None:
    ours, _theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    ours.sendto(b"out of the box", str(OUTSIDE / "datagrams"))


def stream_pair_elsewhere() -> None:
    ours, _theirs = socket.socketpair()
    ours.sendto(b"out of the box", str(OUTSIDE / "datagrams"))


def set_owner() -> None:
    ours, _theirs = os.pipe()
    fcntl.fcntl(ours, fcntl.F_SETOWN, VICTIM)


def lease() -> None:
    with open(KEPT) as file:
        fcntl.fcntl(file, 1024, fcntl.F_RDLCK)


def lock_record() -> None:
    with open(KEPT) as file:
        fcntl.lockf(file, fcntl.LOCK_SH | fcntl.LOCK_NB)


def lock_file() -> None:
    with open(KEPT) as file:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)


def notify() -> None:
    called(LIBC.inotify_add_watch(called(LIBC.inotify_init()), KEPT.encode(), 0xFFF))


def attach_shared() -> None:
    LIBC.shmat.restype = ctypes.c_void_p
    found = LIBC.shmat(SHARED, None, 0)
    if found in (None, 2**64 - 1):
        raise OSError(ctypes.get_errno(), "shmat")
    ctypes.memmove(found, b"changed", 7)


def from_thread() -> None:
    errors: list[BaseException] = []

    def write() -> None:
        try:
            (OUTSIDE / "by_thread").touch()
        except OSError as error:
            errors.append(error)

    thread = threading.Thread(target=write)
    thread.start()
    thread.join()
    if errors:
        raise errors[0]


def leave_group() -> None:
    if (child := os.fork()) == 0:
        try:
            os.setsid()
            os._exit(0)
        except OSError:
            os._exit(1)
    if os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]):
        raise OSError("setsid")


def daemon() -> None:
    """Leave a process behind, which does nothing for a minute; the test looks whether it is gone."""
    if os.fork() == 0:
        for descriptor in range(3):
            os.close(descriptor)
        time.sleep(60)
        os._exit(0)


def fill_disk() -> None:
    with open(SCRATCH / "large", "wb") as file:
        os.posix_fallocate(file.fileno(), 0, 300_000_000)


def fill_memory() -> None:
    mmap.mmap(-1, 1 << 46).close()


def fork_many() -> None:
    children: list[int] = []
    try:
        for _ in range(80 + 4 * (os.cpu_count() or 1)):
            if (child := os.fork()) == 0:
                time.sleep(20)
                os._exit(0)
            children.append(child)
    finally:
        for child in children:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)


def copy_and_run() -> None:
    descriptor = os.memfd_create("program")
    os.write(descriptor, Path("/bin/true").read_bytes())


def own_host_name() -> None:
    name = socket.gethostname().encode()
    called(LIBC.sethostname(name, len(name)))


def read(path: str) -> str:
    return Path(path).read_text(errors="replace")[:40]


OTHER = f"/proc/{VICTIM}"
ATTEMPTS: dict[str, Callable[[], object]] = {
    "write a file": lambda: Path(KEPT).write_text("changed"),
    "make a file": lambda: (OUTSIDE / "made").touch(),
    "make a folder": lambda: (OUTSIDE / "made").mkdir(),
    "remove a file": lambda: os.unlink(KEPT),
    "rename a file": lambda: os.rename(KEPT, OUTSIDE / "renamed"),
    "make a symbolic link": lambda: os.symlink("/etc/hostname", OUTSIDE / "link"),
    "make a pipe": lambda: os.mkfifo(OUTSIDE / "made"),
    "write through a hard link": lambda: write_through("hard", os.link),
    "write through a symbolic link": lambda: write_through("soft", os.symlink),
    "truncate a file": lambda: os.truncate(KEPT, 0),
    "truncate a file that is only read": truncate_for_reading,
    "change the mode": lambda: os.chmod(KEPT, 0o777),
    "change the mode of a folder": lambda: os.chmod(OUTSIDE, 0o777),
    "change the times": lambda: os.utime(KEPT, (0, 0)),
    "change the owner": lambda: os.chown(KEPT, os.getuid(), os.getgid()),
    "set an attribute": lambda: os.setxattr(KEPT, "user.trust", b"1"),
    "remove an attribute": lambda: os.removexattr(KEPT, "user.own"),
    "change the flags": change_flags,
    "lock a file": lock_file,
    "lock a record": lock_record,
    "take a lease": lease,
    "watch a folder": notify,
    "write into a pipe": lambda: os.open(OUTSIDE / "pipe", os.O_WRONLY | os.O_NONBLOCK),
    "make a file without a name": lambda: os.open(OUTSIDE, os.O_TMPFILE | os.O_WRONLY),
    "write shared memory": lambda: Path("/dev/shm/nrp-attempt").touch(),
    "write on the terminal": lambda: os.open("/dev/tty", os.O_RDWR),
    "write from a thread": from_thread,
    "write from a child": lambda: succeeds("touch", str(OUTSIDE / "made")),
    "connect by TCP": lambda: socket.create_connection(("127.0.0.1", PORT), 2),
    "connect by TCP 6": lambda: socket.create_connection(("::1", PORT), 2),
    "send by UDP": lambda: socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b"x", ("127.0.0.1", PORT)),
    "connect a UNIX socket": lambda: socket.socket(socket.AF_UNIX).connect(str(OUTSIDE / "stream")),
    "connect an abstract socket": lambda: socket.socket(socket.AF_UNIX).connect("\0nrp-attempt"),
    "send from a pair": send_pair,
    "send elsewhere from a stream": stream_pair_elsewhere,
    **{
        f"socket {family}": lambda family=family: socket.socket(getattr(socket, family), socket.SOCK_DGRAM)
        for family in FAMILIES
        if hasattr(socket, family)
    },
    "ask whether a process lives": lambda: os.kill(VICTIM, 0),
    "end a process": lambda: os.kill(VICTIM, signal.SIGTERM),
    "end all processes": lambda: None if os.getppid() == 1 else os.kill(VICTIM, signal.SIGKILL),
    "end the group of the parent": lambda: os.killpg(VICTIM, signal.SIGTERM),
    "open a process": lambda: os.pidfd_open(VICTIM),
    "trace a process": lambda: system(101, 117, 16, VICTIM, 0, 0),
    "read the memory of a process": lambda: system(310, 270, VICTIM, 0, 0, 0, 0, 0),
    "write the memory of a process": lambda: system(311, 271, VICTIM, 0, 0, 0, 0, 0),
    "limit a process": lambda: resource.prlimit(VICTIM, resource.RLIMIT_CPU, (1, 1)),
    "read the limits of a process": lambda: resource.prlimit(VICTIM, resource.RLIMIT_CPU),
    "slow a process": lambda: os.setpriority(os.PRIO_PROCESS, VICTIM, 19),
    "move a process": lambda: os.sched_setaffinity(VICTIM, {0}),
    "schedule a process": lambda: os.sched_setscheduler(VICTIM, os.SCHED_IDLE, os.sched_param(0)),
    "own the signals of a pipe": set_owner,
    **{
        f"read {name} of a process": lambda name=name: read(f"{OTHER}/{name}")
        for name in ("environ", "cmdline", "mem", "maps", "stat", "status", "oom_score_adj")
    },
    "list the files of a process": lambda: os.listdir(f"{OTHER}/fd"),
    "list all processes": lambda: os.listdir("/proc"),
    "read the folder of a process": lambda: os.readlink(f"{OTHER}/cwd") and os.listdir(f"{OTHER}/cwd"),
    "attach shared memory": attach_shared,
    "make shared memory": lambda: called(LIBC.shmget(0, 4096, 0o600 | 0o1000)),
    "open a message queue": lambda: system(240, 180, b"nrp-attempt", 0x42, 0o600, None),
    "make a semaphore": lambda: called(LIBC.semget(0, 1, 0o600)),
    "set up io_uring": lambda: system(425, 425, 4, ctypes.create_string_buffer(120)),
    "enter a user namespace": lambda: called(LIBC.unshare(0x10000000)),
    "enter a mount namespace": lambda: called(LIBC.unshare(0x00020000)),
    "clone into a namespace": lambda: system(56, 220, 0x10000000 | signal.SIGCHLD, 0, 0, 0, 0),
    "mount": lambda: called(LIBC.mount(b"none", str(SCRATCH).encode(), b"tmpfs", 0, None)),
    "change the root": lambda: os.chroot(SCRATCH),
    "name the host": own_host_name,
    "become another user": lambda: os.setuid(65534 if os.getuid() == 0 else 0),
    "load a filter": lambda: system(317, 277, 1, 0, 0),
    "use BPF": lambda: system(321, 280, 0, 0, 0),
    "count events": lambda: system(298, 241, 0, VICTIM, -1, -1, 0),
    "use keys": lambda: system(250, 219, 0, -3, 0),
    "leave the group": leave_group,
    "keep a program in memory": copy_and_run,
    "write a large file": fill_disk,
    "reserve much memory": fill_memory,
    "start many processes": fork_many,
    # what a script may do
    "read a file": lambda: read(KEPT),
    "read a program": lambda: Path("/bin/sh").read_bytes()[:4].hex(),
    "write a temporary file": lambda: (SCRATCH / "own").write_text("own"),
    "run a program": lambda: succeeds("true"),
    "leave a process behind": daemon,
}


def outcome(name: str, attempt: Callable[[], object]) -> str:
    """Return ``refused``, or what an attempt returned."""
    print(name, file=sys.stderr)
    try:
        return f"done: {attempt()!r:.80}"
    except (OSError, ValueError, MemoryError, OverflowError):
        return "refused"


if __name__ == "__main__":
    lacking = confine(cpu_s=60.0, writable=[SCRATCH])
    found = {} if lacking else {name: outcome(name, attempt) for name, attempt in ATTEMPTS.items()}
    print(json.dumps({"lacking": lacking, "user": os.getuid(), "found": found}))
