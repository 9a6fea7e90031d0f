"""Memory needs estimated in advance, so that an error is raised before the system ends the process."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from nrp_core.errors import NetworkError

_MEMINFO = Path("/proc/meminfo")
_STATM = Path("/proc/self/statm")
_GROUP = Path("/sys/fs/cgroup")
_LIMITS = (
    ("memory.max", "memory.current"),
    ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes"),
)
"""A container's memory limit and use, in cgroups versions 2 and 1."""


def require_memory(owner: str, needed_bytes: float, what: str) -> None:
    """Check that an object fits into the free memory.

    Args:
        owner: the owner of the memory, for the message, e.g. ``projection 'exc to inh'``.
        needed_bytes: the least memory that it takes.
        what: a description of the object, with its counts.

    Raises:
        NetworkError: it does not fit; the message has all the numbers.
    """
    free = free_bytes()
    if free is not None and needed_bytes > free:
        raise NetworkError(
            f"{owner}: {what} would take {_size(needed_bytes)} of memory, and {_size(free)} are free; "
            "make it smaller, or use a machine with more"
        )


def free_bytes() -> int | None:
    """Return the memory available to this process, by the machine, its container and its own limit.

    None if the system does not report it.
    """
    return min(_bounds(), default=None)


def _bounds() -> Iterator[int]:
    if _MEMINFO.exists():
        for line in _MEMINFO.read_text().splitlines():
            if line.startswith("MemAvailable:"):
                yield int(line.split()[1]) * 1024
    for limit, used in _LIMITS:
        if (_GROUP / limit).exists() and (text := (_GROUP / limit).read_text().strip()).isdigit():
            yield max(0, int(text) - int((_GROUP / used).read_text()))
    try:
        import resource
    except ImportError:  # on Windows
        return
    own, _ = resource.getrlimit(resource.RLIMIT_AS)
    if own != resource.RLIM_INFINITY and _STATM.exists():
        yield max(0, own - int(_STATM.read_text().split()[0]) * resource.getpagesize())


def _size(n_bytes: float) -> str:
    for unit in ("bytes", "KiB", "MiB", "GiB", "TiB"):
        if n_bytes < 1024:
            return f"{n_bytes:.0f} {unit}" if unit == "bytes" else f"{n_bytes:.1f} {unit}"
        n_bytes /= 1024
    return f"{n_bytes:,.1f} PiB"
